package vantage.spy;

import java.awt.BorderLayout;
import java.awt.GridLayout;
import java.awt.Window;
import java.util.ArrayList;
import java.util.List;
import java.util.concurrent.Executor;
import javax.swing.BorderFactory;
import javax.swing.JComponent;
import javax.swing.JLabel;
import javax.swing.JPanel;
import javax.swing.SwingUtilities;
import vantage.images_t;

/** The images of a camera side by side: depth in false color, color as it is. */
final class PicturesView implements MessageView {
  private final JPanel panel = new JPanel(new BorderLayout());
  private final JPanel pictures = new JPanel(new GridLayout(1, 0, 2, 0));
  private final JLabel leftOut = new JLabel();
  private final List<PicturePanel> shown = new ArrayList<>();

  PicturesView(Executor worker) {
    leftOut.putClientProperty("html.disable", Boolean.TRUE);
    leftOut.setBorder(BorderFactory.createEmptyBorder(2, 8, 2, 8));
    leftOut.setVisible(false);
    panel.add(pictures, BorderLayout.CENTER);
    panel.add(leftOut, BorderLayout.SOUTH);
    setCount(1);
  }

  @Override
  public JComponent component() {
    return panel;
  }

  @Override
  public Runnable prepare(Object message) {
    Pictures received = Pictures.of((images_t) message);
    return () -> {
      setCount(received.shown().size());
      for (int i = 0; i < received.shown().size(); i++) {
        shown.get(i).show(received.shown().get(i));
      }
      leftOut.setText(Text.line(received.leftOut()));
      leftOut.setVisible(!received.leftOut().isEmpty());
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
    pictures.removeAll();
    shown.clear();
    for (int i = 0; i < count; i++) {
      shown.add(new PicturePanel(count == 1 ? 640 : 480));
      pictures.add(shown.get(i).component());
    }
    panel.revalidate();
    Window window = SwingUtilities.getWindowAncestor(panel);
    if (window != null) {
      window.pack();
    }
  }
}
