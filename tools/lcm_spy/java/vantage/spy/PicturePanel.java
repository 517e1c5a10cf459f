package vantage.spy;

import java.awt.BorderLayout;
import java.awt.Color;
import java.awt.Dimension;
import java.awt.Graphics;
import java.awt.Point;
import java.awt.event.MouseAdapter;
import java.awt.event.MouseEvent;
import java.awt.image.BufferedImage;
import javax.swing.BorderFactory;
import javax.swing.JComponent;
import javax.swing.JLabel;
import javax.swing.JPanel;

/** One image, as large as the window allows, with a color scale for depth and a line of values. */
final class PicturePanel {
  private static final int SCALE_WIDTH = 58; // px, of the color scale with its numbers
  private static final int BAR_WIDTH = 14; // px
  private static final int GAP = 8; // px

  private final JPanel panel = new JPanel(new BorderLayout());
  private final JLabel line = new JLabel(" ");
  private final Canvas canvas = new Canvas();
  private transient Picture picture;
  private Point mouse;

  /** Wide as an image of 4 to 3 is to be shown, px. */
  PicturePanel(int width) {
    canvas.setPreferredSize(new Dimension(width + SCALE_WIDTH + GAP, 3 * width / 4));
    line.putClientProperty("html.disable", Boolean.TRUE);
    line.setName("picture line");
    line.setBorder(BorderFactory.createEmptyBorder(2, 8, 2, 8));
    canvas.setName("picture");
    panel.add(canvas, BorderLayout.CENTER);
    panel.add(line, BorderLayout.SOUTH);
    MouseAdapter follow = new MouseAdapter() {
      @Override
      public void mouseMoved(MouseEvent event) {
        mouse = event.getPoint();
        showLine();
      }

      @Override
      public void mouseExited(MouseEvent event) {
        mouse = null;
        showLine();
      }
    };
    canvas.addMouseListener(follow);
    canvas.addMouseMotionListener(follow);
  }

  JComponent component() {
    return panel;
  }

  void show(Picture shown) {
    picture = shown;
    canvas.image = new BufferedImage(shown.width(), shown.height(), BufferedImage.TYPE_INT_RGB);
    canvas.image.setRGB(0, 0, shown.width(), shown.height(), shown.rgb(), 0, shown.width());
    showLine();
    canvas.repaint();
  }

  private void showLine() {
    if (picture == null) {
      return;
    }
    String text = picture.describe();
    if (mouse != null) {
      double scale = canvas.scale();
      String pixel = picture.describePixel(
          (int) Math.floor((mouse.x - canvas.left()) / scale),
          (int) Math.floor((mouse.y - canvas.top()) / scale));
      text += pixel.isEmpty() ? "" : "   " + pixel;
    }
    line.setText(text);
  }

  private final class Canvas extends JComponent {
    private static final long serialVersionUID = 1;
    private transient BufferedImage image;

    private int scaleWidth() {
      return picture != null && picture.depth() != null ? SCALE_WIDTH + GAP : 0;
    }

    private double scale() {
      double wide = (getWidth() - scaleWidth()) / (double) picture.width();
      return Math.max(1e-3, Math.min(wide, getHeight() / (double) picture.height()));
    }

    private int left() {
      return (int) (getWidth() - scaleWidth() - scale() * picture.width()) / 2;
    }

    private int top() {
      return (int) (getHeight() - scale() * picture.height()) / 2;
    }

    @Override
    protected void paintComponent(Graphics g) {
      g.setColor(new Color(0x1b1d22));
      g.fillRect(0, 0, getWidth(), getHeight());
      if (picture == null) {
        return;
      }
      int width = (int) (scale() * picture.width());
      int height = (int) (scale() * picture.height());
      g.drawImage(image, left(), top(), width, height, null);
      if (picture.depth() != null && picture.depth().numValid() > 0) {
        paintScale(g, picture.depth(), top(), height);
      }
    }

    private void paintScale(Graphics g, Picture.Depth depth, int top, int height) {
      int x = getWidth() - SCALE_WIDTH;
      for (int v = 0; v < height; v++) {
        g.setColor(new Color(Colors.depth(v / Math.max(1.0, height - 1))));
        g.drawLine(x, top + v, x + BAR_WIDTH, top + v);
      }
      g.setColor(Color.WHITE);
      int numLabels = Math.max(1, Math.min(6, height / 40));
      for (int i = 0; i <= numLabels; i++) {
        double share = i / (double) numLabels;
        long value =
            Math.round(depth.scaleNear() + share * (depth.scaleFar() - depth.scaleNear()));
        int y = top + 10 + (int) (share * (height - 12));
        g.drawString(Long.toString(value), x + BAR_WIDTH + 4, y);
      }
    }
  }
}
