package vantage.spy;

import java.util.zip.DataFormatException;
import java.util.zip.Inflater;
import vantage.DepthCodec;
import vantage.image_t;
import vantage.images_t;

/** Depth images in false color. */
final class DepthPicture {
  private static final int VALUES = 1 << 16;
  private static final double SCALED_SHARE = 0.98; // Of the pixels that the color scale spans.

  private DepthPicture() {}

  static boolean isDepth(short type) {
    return type == images_t.DEPTH_MM
        || type == images_t.DEPTH_MM_ZIPPED
        || type == images_t.DEPTH_MM_VDC;
  }

  /** Throws an IllegalArgumentException when bytes and size do not belong together. */
  static Picture of(image_t image, short type) {
    ImageSize.check(image);
    String title;
    short[] millimetres;
    if (type == images_t.DEPTH_MM_VDC) {
      title = "depth, VDC";
      millimetres = decodeVdc(image);
    } else if (type == images_t.DEPTH_MM_ZIPPED) {
      title = "depth, zlib";
      ImageSize.checkStride(image, 2 * image.width, false);
      millimetres = fromBytes(inflate(image), image);
    } else {
      title = "depth, raw";
      ImageSize.checkStride(image, 2 * image.width, true);
      ImageSize.checkBytes(image);
      millimetres = fromBytes(image.data, image);
    }
    title += ", " + Text.number(image.data.length / 1000.0, 1) + " kB";
    return colored(title, image.width, image.height, millimetres);
  }

  private static short[] decodeVdc(image_t image) {
    try {
      DepthCodec.Image decoded = DepthCodec.decode(image.data);
      if (decoded.width() != image.width || decoded.height() != image.height) {
        throw new IllegalArgumentException("the depth codec's image is " + decoded.width() + " x "
            + decoded.height() + " px, the message says " + image.width + " x " + image.height);
      }
      return decoded.pixels();
    } catch (DepthCodec.CorruptException problem) {
      throw new IllegalArgumentException(
          "the depth codec refuses the image: " + problem.getMessage(), problem);
    }
  }

  private static byte[] inflate(image_t image) {
    byte[] bytes = new byte[image.row_stride * image.height];
    Inflater inflater = new Inflater();
    try {
      inflater.setInput(image.data);
      int length = 0;
      while (length < bytes.length && !inflater.finished()) {
        int added = inflater.inflate(bytes, length, bytes.length - length);
        if (added == 0 && (inflater.needsInput() || inflater.needsDictionary())) {
          break;
        }
        length += added;
      }
      int more = inflater.finished() ? 0 : inflater.inflate(new byte[1]);
      boolean ended = inflater.finished() && more == 0 && inflater.getRemaining() == 0;
      if (length != bytes.length || !ended) {
        throw new IllegalArgumentException(
            "the zlib stream holds other than " + bytes.length + " bytes");
      }
      return bytes;
    } catch (DataFormatException problem) {
      throw new IllegalArgumentException("the zlib stream is damaged", problem);
    } finally {
      inflater.end();
    }
  }

  private static short[] fromBytes(byte[] bytes, image_t image) {
    short[] millimetres = new short[image.width * image.height];
    for (int v = 0; v < image.height; v++) {
      int at = v * image.row_stride;
      for (int u = 0; u < image.width; u++, at += 2) {
        millimetres[v * image.width + u] = (short) (bytes[at] & 0xff | bytes[at + 1] << 8);
      }
    }
    return millimetres;
  }

  private static Picture colored(String title, int width, int height, short[] millimetres) {
    int[] counts = new int[VALUES];
    for (short value : millimetres) {
      counts[value & 0xffff]++;
    }
    int numValid = millimetres.length - counts[0];
    int outside = (int) (0.5 * (1 - SCALED_SHARE) * numValid);
    Picture.Depth depth = new Picture.Depth(
        millimetres,
        numValid,
        valueAt(counts, 0),
        valueAt(counts, numValid - 1),
        valueAt(counts, outside),
        valueAt(counts, numValid - 1 - outside));
    int[] colorOf = new int[VALUES];
    double span = Math.max(1, depth.scaleFar() - depth.scaleNear());
    for (int value = 1; value < VALUES; value++) {
      colorOf[value] = counts[value] == 0 ? 0 : Colors.depth((value - depth.scaleNear()) / span);
    }
    colorOf[0] = Colors.NO_DEPTH;
    int[] rgb = new int[millimetres.length];
    for (int i = 0; i < rgb.length; i++) {
      rgb[i] = colorOf[millimetres[i] & 0xffff];
    }
    return new Picture(title, width, height, rgb, depth);
  }

  // The value of the valid pixel at a place in ascending order; 0 when there is none.
  private static int valueAt(int[] counts, int place) {
    int before = 0;
    for (int value = 1; value < VALUES; value++) {
      before += counts[value];
      if (before > place) {
        return value;
      }
    }
    return 0;
  }
}
