package vantage.spy;

import vantage.image_t;

/** What the sizes in an image_t must fulfil before anything is allocated by them. */
final class ImageSize {
  static final int MAX_SIDE = 4096; // px

  private ImageSize() {}

  static void check(image_t image) {
    if (image.width < 1 || image.height < 1 || image.width > MAX_SIDE || image.height > MAX_SIDE) {
      throw new IllegalArgumentException("an image of " + image.width + " x " + image.height
          + " px, expected sides of 1 to " + MAX_SIDE);
    }
  }

  /** The row stride is `rowBytes`, or more where rows may have an end that is not shown. */
  static void checkStride(image_t image, int rowBytes, boolean longerToo) {
    boolean sound = longerToo ? image.row_stride >= rowBytes : image.row_stride == rowBytes;
    if (!sound) {
      throw new IllegalArgumentException("an image of " + image.width
          + " px a row has a row stride of " + image.row_stride + " bytes, expected " + rowBytes + (longerToo ? " or more" : ""));
    }
  }

  /** As many bytes as the rows take. */
  static void checkBytes(image_t image) {
    long expected = (long) image.row_stride * image.height;
    if (image.data.length != expected) {
      throw new IllegalArgumentException("an image of " + image.height + " rows of "
          + image.row_stride + " bytes has " + image.data.length + " bytes, expected " + expected);
    }
  }
}
