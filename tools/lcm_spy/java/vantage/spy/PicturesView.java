package vantage.spy;

import java.awt.GridLayout;
import java.awt.Window;
import java.util.ArrayList;
import java.util.List;
import java.util.concurrent.Executor;
import javax.swing.JComponent;
import javax.swing.JPanel;
import javax.swing.SwingUtilities;
import vantage.images_t;

/** The images of a camera side by side: depth in false color, color as it is. */
final class PicturesView implements MessageView {
  private final JPanel panel = new JPanel(new GridLayout(1, 0, 2, 0));
  private final List<PicturePanel> shown = new ArrayList<>();

  PicturesView(Executor worker) {
    setCount(1);
  }

  @Override
  public JComponent component() {
    return panel;
  }

  @Override
  public Runnable prepare(Object message) {
    List<Picture> pictures = Pictures.of((images_t) message);
    return () -> {
      setCount(pictures.size());
      for (int i = 0; i < pictures.size(); i++) {
        shown.get(i).show(pictures.get(i));
      }
    };
  }

  @Override
  public long seq(Object message) {
    return Pictures.seq((images_t) message);
  }

  private void setCount(int count) {
    if (shown.size() == count) {
      return;
    }
    panel.removeAll();
    shown.clear();
    for (int i = 0; i < count; i++) {
      shown.add(new PicturePanel(count == 1 ? 640 : 480));
      panel.add(shown.get(i).component());
    }
    panel.revalidate();
    Window window = SwingUtilities.getWindowAncestor(panel);
    if (window != null) {
      window.pack();
    }
  }
}
