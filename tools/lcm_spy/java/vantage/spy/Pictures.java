package vantage.spy;

import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.ArrayList;
import java.util.List;
import vantage.image_metadata_t;
import vantage.image_t;
import vantage.images_t;

/**
 * The images of a message.
 *
 * @param shown at least one
 * @param leftOut why another one is missing; empty: none is
 */
record Pictures(List<Picture> shown, String leftOut) {
  private static final int MAX_IMAGES = 8;

  /** Throws an IllegalArgumentException when none of them can be shown. */
  static Pictures of(images_t message) {
    if (message.images.length == 0) {
      throw new IllegalArgumentException("a message without an image");
    }
    if (message.images.length > MAX_IMAGES) {
      throw new IllegalArgumentException(
          message.images.length + " images in a message, expected at most " + MAX_IMAGES);
    }
    List<Picture> shown = new ArrayList<>();
    IllegalArgumentException problem = null;
    for (int i = 0; i < message.images.length; i++) {
      short type = message.image_types[i];
      try {
        shown.add(DepthPicture.isDepth(type)
            ? DepthPicture.of(message.images[i], type) : ColorPicture.of(message.images[i]));
      } catch (IllegalArgumentException refusal) {
        problem = refusal;
      }
    }
    if (shown.isEmpty()) {
      throw problem;
    }
    return new Pictures(shown, problem == null ? "" : "left out: " + problem.getMessage());
  }

  /** The metadata "seq" of the first image that has it; -1 where none has. */
  static long seq(images_t message) {
    for (image_t image : message.images) {
      for (image_metadata_t metadata : image.metadata) {
        if (metadata.key.equals("seq") && metadata.value.length == Long.BYTES) {
          return ByteBuffer.wrap(metadata.value).order(ByteOrder.LITTLE_ENDIAN).getLong();
        }
      }
    }
    return -1;
  }
}
