package vantage.spy;

import java.awt.Component;
import java.awt.Container;
import java.awt.Frame;
import java.awt.Rectangle;
import java.awt.Robot;
import java.awt.Window;
import java.awt.event.MouseEvent;
import java.awt.image.BufferedImage;
import java.io.File;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.concurrent.Callable;
import java.util.concurrent.FutureTask;
import java.util.function.Predicate;
import javax.imageio.ImageIO;
import javax.swing.JComboBox;
import javax.swing.JFrame;
import javax.swing.JLabel;
import javax.swing.JMenuItem;
import javax.swing.JTable;
import javax.swing.MenuElement;
import javax.swing.MenuSelectionManager;
import javax.swing.SwingUtilities;

/** Uses lcm-spy's windows from within its process as a person would, and looks at them. */
final class SpyDriver {
  private static final long PATIENCE_MS = 40_000;

  private SpyDriver() {}

  /** Runs on the Swing thread. */
  static <T> T onSwing(Callable<T> task) throws Exception {
    FutureTask<T> future = new FutureTask<>(task);
    SwingUtilities.invokeAndWait(future);
    return future.get();
  }

  /** Until it holds; fails with the sentence after a long time. */
  static void waitUntil(String sentence, Callable<Boolean> holds) throws Exception {
    long end = System.nanoTime() + PATIENCE_MS * 1_000_000;
    while (!onSwing(holds)) {
      if (System.nanoTime() > end) {
        throw new AssertionError("not so after " + PATIENCE_MS / 1000 + " s: " + sentence);
      }
      Thread.sleep(100);
    }
  }

  /** Tries again what may come too early; fails as the last try did after a long time. */
  static void eventually(Callable<Void> attempt) throws Exception {
    long end = System.nanoTime() + PATIENCE_MS * 1_000_000;
    while (true) {
      try {
        attempt.call();
        return;
      } catch (AssertionError problem) {
        if (System.nanoTime() > end) {
          throw problem;
        }
        Thread.sleep(300);
      }
    }
  }

  /** The visible frame whose title begins so; null where there is none. */
  static JFrame frame(String title) {
    return frame(whole -> whole.startsWith(title));
  }

  static JFrame frame(Predicate<String> title) {
    for (Frame frame : Frame.getFrames()) {
      if (frame.isVisible() && title.test(frame.getTitle()) && frame instanceof JFrame found) {
        return found;
      }
    }
    return null;
  }

  /** All parts of a kind, in the order of the tree. */
  static <T extends Component> List<T> parts(Container tree, Class<T> kind, Predicate<T> wanted) {
    List<T> found = new ArrayList<>();
    for (Component part : tree.getComponents()) {
      if (kind.isInstance(part) && wanted.test(kind.cast(part))) {
        found.add(kind.cast(part));
      }
      if (part instanceof Container container) {
        found.addAll(parts(container, kind, wanted));
      }
    }
    return found;
  }

  static <T extends Component> T named(Container tree, Class<T> kind, String name) {
    List<T> found = parts(tree, kind, part -> name.equals(part.getName()));
    return found.isEmpty() ? null : found.get(0);
  }

  static String text(Container tree, String name) {
    JLabel label = named(tree, JLabel.class, name);
    return label == null ? "" : label.getText();
  }

  static JTable table(Container tree, int index) {
    List<JTable> tables = parts(tree, JTable.class, part -> true);
    return index < tables.size() ? tables.get(index) : null;
  }

  /** A table's line by the text of its first cells; null where there is none. */
  static String[] row(JTable table, String... begin) {
    for (int r = 0; r < table.getRowCount(); r++) {
      String[] cells = new String[table.getColumnCount()];
      for (int c = 0; c < cells.length; c++) {
        cells[c] = String.valueOf(table.getValueAt(r, c)).trim();
      }
      if (Arrays.equals(Arrays.copyOf(cells, begin.length), begin)) {
        return cells;
      }
    }
    return null;
  }

  /** Double-clicks a channel in lcm-spy's list. On the Swing thread. */
  static void open(String channel) {
    click(channel, MouseEvent.BUTTON1, 2);
  }

  /** Right-clicks a channel and takes an item of the menu. On the Swing thread. */
  static void chooseFromMenu(String channel, String item) {
    click(channel, MouseEvent.BUTTON3, 1);
    for (MenuElement element : MenuSelectionManager.defaultManager().getSelectedPath()) {
      for (JMenuItem found : parts((Container) element, JMenuItem.class,
          part -> item.equals(part.getText()))) {
        found.doClick();
        MenuSelectionManager.defaultManager().clearSelectedPath();
        return;
      }
    }
    throw new AssertionError("no menu item " + item + " on " + channel);
  }

  private static void click(String channel, int button, int count) {
    JTable table = table(frame("LCM Spy"), 0);
    for (int r = 0; r < table.getRowCount(); r++) {
      if (channel.equals(String.valueOf(table.getValueAt(r, 0)).trim())) {
        Rectangle cell = table.getCellRect(r, 0, true);
        table.dispatchEvent(new MouseEvent(
            table, MouseEvent.MOUSE_CLICKED, System.currentTimeMillis(), 0, cell.x + 2,
            cell.y + cell.height / 2, count, false, button));
        return;
      }
    }
    throw new AssertionError("no channel " + channel + " in the list");
  }

  static void choose(JComboBox<?> box, String item) {
    for (int i = 0; i < box.getItemCount(); i++) {
      if (item.equals(String.valueOf(box.getItemAt(i)))) {
        box.setSelectedIndex(i);
        return;
      }
    }
    throw new AssertionError("no item " + item);
  }

  /** What the screen shows of a part, also kept as a file where a folder is given. */
  static BufferedImage screenshot(Component part, String file) throws Exception {
    Window window = part instanceof Window itself ? itself : SwingUtilities.getWindowAncestor(part);
    onSwing(() -> {
      window.toFront();
      return null;
    });
    Thread.sleep(400); // Until the server has drawn what came to the front.
    Rectangle place =
        onSwing(() -> new Rectangle(part.getLocationOnScreen(), part.getSize()));
    BufferedImage image = new Robot().createScreenCapture(place);
    String folder = System.getenv("VANTAGE_SPY_SCREENSHOTS");
    if (folder != null) {
      ImageIO.write(image, "png", new File(folder, file + ".png"));
    }
    return image;
  }
}
