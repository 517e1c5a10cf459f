package vantage.spy;

import java.awt.Color;
import java.awt.Graphics2D;
import java.awt.RenderingHints;
import java.awt.image.BufferedImage;

/** Two halves of a sphere, near side on the left and far side on the right, with the axes' ends. */
final class SpherePicture {
  static final int MARGIN = 10; // px
  static final int BACKGROUND = 0xffffff;
  private static final int[] AXIS_COLORS = {0xd02e2e, 0x2c963c, 0x2854d0};

  private SpherePicture() {}

  /** 4 radius + 3 MARGIN wide, 2 radius + 2 MARGIN high, and a pixel more for each half. */
  static BufferedImage of(SphereSamples samples, double[] towards, int radius) {
    Hemisphere near = new Hemisphere(towards, radius);
    Hemisphere far =
        new Hemisphere(new double[] {-towards[0], -towards[1], -towards[2]}, radius);
    near.add(samples);
    far.add(samples);
    double highest = Math.max(near.highest(), far.highest());
    int size = near.size();
    BufferedImage image = new BufferedImage(
        2 * size + 3 * MARGIN, size + 2 * MARGIN, BufferedImage.TYPE_INT_RGB);
    Graphics2D g = image.createGraphics();
    g.setRenderingHint(RenderingHints.KEY_ANTIALIASING, RenderingHints.VALUE_ANTIALIAS_ON);
    g.setColor(new Color(BACKGROUND));
    g.fillRect(0, 0, image.getWidth(), image.getHeight());
    draw(near, highest, MARGIN, image, g);
    draw(far, highest, 2 * MARGIN + size, image, g);
    g.dispose();
    return image;
  }

  private static void draw(
      Hemisphere half, double highest, int left, BufferedImage image, Graphics2D g) {
    int size = half.size();
    image.setRGB(left, MARGIN, size, size, half.paint(highest, BACKGROUND), 0, size);
    for (int axis = 0; axis < 3; axis++) {
      for (int sign = -1; sign <= 1; sign += 2) {
        double[] end = new double[3];
        end[axis] = sign;
        if (half.toView(end)[2] < -0.05) {
          continue;
        }
        double x = left + half.columnOf(end);
        double y = MARGIN + half.rowOf(end);
        disk(g, x, y, 5, Color.WHITE);
        disk(g, x, y, 4, new Color(AXIS_COLORS[axis]));
        if (sign < 0) {
          disk(g, x, y, 2, Color.WHITE);
        }
      }
    }
  }

  private static void disk(Graphics2D g, double x, double y, int radius, Color color) {
    g.setColor(color);
    g.fillOval(
        (int) Math.round(x) - radius, (int) Math.round(y) - radius, 2 * radius + 1, 2 * radius + 1);
  }
}
