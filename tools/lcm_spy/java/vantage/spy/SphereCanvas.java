package vantage.spy;

import java.awt.Color;
import java.awt.Dimension;
import java.awt.Graphics;
import java.awt.image.BufferedImage;
import javax.swing.JComponent;

/** Shows a picture of spheres in its middle. */
final class SphereCanvas extends JComponent {
  private static final long serialVersionUID = 1;
  private transient BufferedImage image;

  void show(BufferedImage shown) {
    image = shown;
    repaint();
  }

  @Override
  public Dimension getPreferredSize() {
    return new Dimension(800, 410);
  }

  @Override
  protected void paintComponent(Graphics g) {
    g.setColor(new Color(SpherePicture.BACKGROUND));
    g.fillRect(0, 0, getWidth(), getHeight());
    if (image != null) {
      int left = (getWidth() - image.getWidth()) / 2;
      g.drawImage(image, left, (getHeight() - image.getHeight()) / 2, null);
    }
  }
}
