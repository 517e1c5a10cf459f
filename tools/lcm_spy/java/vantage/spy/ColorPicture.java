package vantage.spy;

import java.awt.image.BufferedImage;
import java.io.ByteArrayInputStream;
import java.io.IOException;
import java.util.Iterator;
import javax.imageio.ImageIO;
import javax.imageio.ImageReader;
import javax.imageio.stream.ImageInputStream;
import javax.imageio.stream.MemoryCacheImageInputStream;
import vantage.image_t;

/** Images of color cameras, in the pixel formats that Vantage's drivers publish, and BGR. */
final class ColorPicture {
  private ColorPicture() {}

  /** Throws an IllegalArgumentException when it cannot be shown. */
  static Picture of(image_t image) {
    ImageSize.check(image);
    return switch (image.pixelformat) {
      case image_t.PIXEL_FORMAT_RGB -> fromBytes("color, RGB", image, 3, 0, 1, 2);
      case image_t.PIXEL_FORMAT_BGR -> fromBytes("color, BGR", image, 3, 2, 1, 0);
      case image_t.PIXEL_FORMAT_GRAY -> fromBytes("gray", image, 1, 0, 0, 0);
      case image_t.PIXEL_FORMAT_MJPEG -> fromJpeg(image);
      default -> throw new IllegalArgumentException(
          "an image of pixel format " + image.pixelformat + ", expected RGB, BGR, GRAY or MJPEG");
    };
  }

  private static Picture fromBytes(String title, image_t image, int size, int r, int g, int b) {
    ImageSize.checkStride(image, size * image.width, true);
    ImageSize.checkBytes(image);
    int[] rgb = new int[image.width * image.height];
    byte[] data = image.data;
    for (int v = 0; v < image.height; v++) {
      int at = v * image.row_stride;
      for (int u = 0; u < image.width; u++, at += size) {
        rgb[v * image.width + u] =
            (data[at + r] & 0xff) << 16 | (data[at + g] & 0xff) << 8 | data[at + b] & 0xff;
      }
    }
    return new Picture(title, image.width, image.height, rgb, null);
  }

  private static Picture fromJpeg(image_t image) {
    Iterator<ImageReader> readers = ImageIO.getImageReadersByFormatName("jpeg");
    ImageReader reader = readers.next();
    try (ImageInputStream stream =
        new MemoryCacheImageInputStream(new ByteArrayInputStream(image.data))) {
      reader.setInput(stream, true, true);
      if (reader.getWidth(0) != image.width || reader.getHeight(0) != image.height) {
        throw new IllegalArgumentException("the JPEG is " + reader.getWidth(0) + " x "
            + reader.getHeight(0) + " px, the message says " + image.width + " x " + image.height);
      }
      BufferedImage decoded = reader.read(0);
      int[] rgb = decoded.getRGB(0, 0, image.width, image.height, null, 0, image.width);
      for (int i = 0; i < rgb.length; i++) {
        rgb[i] &= 0xffffff;
      }
      return new Picture("color, JPEG", image.width, image.height, rgb, null);
    } catch (IOException problem) {
      throw new IllegalArgumentException("the JPEG is damaged: " + problem.getMessage(), problem);
    } finally {
      reader.dispose();
    }
  }
}
