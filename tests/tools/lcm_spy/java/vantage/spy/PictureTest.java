package vantage.spy;

import java.awt.image.BufferedImage;
import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.Arrays;
import java.util.zip.CRC32C;
import java.util.zip.Deflater;
import javax.imageio.ImageIO;
import vantage.image_metadata_t;
import vantage.image_t;
import vantage.images_t;

/** Images of messages become pixels, or are refused. */
public final class PictureTest {
  private static final int WIDTH = 5;
  private static final int HEIGHT = 3;
  private static final int[] DEPTH = {
    0, 500, 600, 700, 0, 65535, 600, 600, 600, 600, 0, 0, 0, 600, 40000
  };

  private PictureTest() {}

  public static void main(String[] arguments) throws IllegalAccessException {
    Check.runAll(PictureTest.class);
  }

  private static image_t image(int width, int height, int stride, byte[] data) {
    image_t image = new image_t();
    image.width = width;
    image.height = height;
    image.row_stride = stride;
    image.pixelformat = image_t.PIXEL_FORMAT_INVALID;
    image.data = data;
    image.size = data.length;
    image.metadata = new image_metadata_t[0];
    return image;
  }

  private static byte[] depthBytes(int stride) {
    ByteBuffer bytes = ByteBuffer.allocate(stride * HEIGHT).order(ByteOrder.LITTLE_ENDIAN);
    for (int i = 0; i < DEPTH.length; i++) {
      bytes.putShort(i / WIDTH * stride + 2 * (i % WIDTH), (short) DEPTH[i]);
    }
    return bytes.array();
  }

  private static byte[] deflated(byte[] bytes) {
    byte[] stream = new byte[bytes.length + 100];
    Deflater deflater = new Deflater();
    deflater.setInput(bytes);
    deflater.finish();
    int length = deflater.deflate(stream);
    deflater.end();
    return Arrays.copyOf(stream, length);
  }

  // An image of the depth codec that is stored as it is.
  private static byte[] stored(int width, int height, byte[] pixels) {
    ByteBuffer bytes = ByteBuffer.allocate(13 + pixels.length).order(ByteOrder.LITTLE_ENDIAN);
    bytes.putInt(0, 0x01434456).putShort(8, (short) width).putShort(10, (short) height);
    bytes.position(13);
    bytes.put(pixels);
    CRC32C checksum = new CRC32C();
    checksum.update(bytes.array(), 8, bytes.capacity() - 8);
    bytes.putInt(4, (int) checksum.getValue());
    return bytes.array();
  }

  private static void checkDepth(Picture picture) {
    Check.equal(picture.depth().numValid(), 10);
    Check.equal(picture.depth().nearest(), 500);
    Check.equal(picture.depth().farthest(), 65535);
    for (int i = 0; i < DEPTH.length; i++) {
      Check.equal(picture.depth().millimetres()[i] & 0xffff, DEPTH[i]);
      Check.equal(picture.rgb()[i] == Colors.NO_DEPTH, DEPTH[i] == 0);
    }
    Check.equal(picture.describePixel(0, 1), "(0, 1): 65535 mm");
    Check.equal(picture.describePixel(4, 0), "(4, 0): no measurement");
    Check.equal(picture.describePixel(5, 0), "");
    Check.equal(picture.describePixel(0, -1), "");
  }

  static void testDepthIsTheSameByAllThreeWays() {
    checkDepth(DepthPicture.of(image(WIDTH, HEIGHT, 10, depthBytes(10)), images_t.DEPTH_MM));
    checkDepth(DepthPicture.of(image(WIDTH, HEIGHT, 16, depthBytes(16)), images_t.DEPTH_MM));
    checkDepth(DepthPicture.of(
        image(WIDTH, HEIGHT, 10, deflated(depthBytes(10))), images_t.DEPTH_MM_ZIPPED));
    checkDepth(DepthPicture.of(
        image(WIDTH, HEIGHT, 10, stored(WIDTH, HEIGHT, depthBytes(10))), images_t.DEPTH_MM_VDC));
  }

  static void testDepthWithoutMeasurement() {
    Picture picture = DepthPicture.of(image(4, 2, 8, new byte[16]), images_t.DEPTH_MM);
    Check.equal(picture.depth().numValid(), 0);
    Check.that(picture.describe().contains("no measurement"), picture.describe());
    Check.that(Arrays.stream(picture.rgb()).allMatch(c -> c == Colors.NO_DEPTH), "not all dark");
  }

  static void testNearIsLighterThanFar() {
    int before = 3 * 256;
    for (int i = 0; i <= 50; i++) {
      int color = Colors.depth(i / 50.0);
      int lightness = (color >> 16) + (color >> 8 & 0xff) + (color & 0xff);
      Check.that(lightness <= before, "lighter at " + i);
      before = lightness;
    }
    Check.equal(Colors.depth(Double.NaN), Colors.depth(0));
    Check.equal(Colors.depth(7), Colors.depth(1));
  }

  static void testSizesThatDoNotFitAreRefused() throws Exception {
    byte[] sound = depthBytes(10);
    short raw = images_t.DEPTH_MM;
    int[] sides = {0, -1, 4097, Integer.MAX_VALUE, Integer.MIN_VALUE};
    for (int side : sides) {
      Check.refused("expected sides", () -> DepthPicture.of(image(side, 3, 10, sound), raw));
      Check.refused("expected sides", () -> DepthPicture.of(image(5, side, 10, sound), raw));
      Check.refused("expected sides", () -> ColorPicture.of(image(side, 3, 10, sound)));
    }
    for (int stride : new int[] {9, 0, -10, Integer.MIN_VALUE}) {
      Check.refused("row stride", () -> DepthPicture.of(image(5, 3, stride, sound), raw));
    }
    Check.refused("expected", () -> DepthPicture.of(image(5, 3, Integer.MAX_VALUE, sound), raw));
    Check.refused("has 30 bytes", () -> DepthPicture.of(image(5, 4, 10, sound), raw));
    Check.refused("row stride", () ->
        DepthPicture.of(image(5, 3, 16, deflated(sound)), images_t.DEPTH_MM_ZIPPED));
  }

  static void testDamagedStreamsAreRefused() throws Exception {
    byte[] zipped = deflated(depthBytes(10));
    short zlib = images_t.DEPTH_MM_ZIPPED;
    Check.refused("zlib", () -> DepthPicture.of(
        image(5, 3, 10, Arrays.copyOf(zipped, zipped.length - 5)), zlib));
    Check.refused("zlib", () -> DepthPicture.of(image(5, 3, 10, new byte[0]), zlib));
    Check.refused("zlib", () -> DepthPicture.of(
        image(5, 3, 10, Arrays.copyOf(zipped, zipped.length + 1)), zlib));
    Check.refused("zlib", () ->
        DepthPicture.of(image(5, 3, 10, deflated(new byte[1 << 20])), zlib));
    Check.refused("zlib", () -> DepthPicture.of(image(5, 4, 10, zipped), zlib));
    byte[] vdc = stored(5, 3, depthBytes(10));
    Check.refused("the message says", () ->
        DepthPicture.of(image(3, 5, 6, vdc), images_t.DEPTH_MM_VDC));
    for (int i = 0; i < vdc.length; i++) {
      byte[] damaged = vdc.clone();
      damaged[i] ^= 4;
      image_t image = image(5, 3, 10, damaged);
      Check.refused("codec", () -> DepthPicture.of(image, images_t.DEPTH_MM_VDC));
    }
  }

  static void testColorsKeepTheirOrder() throws Exception {
    byte[] bytes = {10, 20, 30, (byte) 200, (byte) 210, (byte) 220, 99};
    image_t image = image(2, 1, 7, bytes);
    image.pixelformat = image_t.PIXEL_FORMAT_RGB;
    Check.that(Arrays.equals(ColorPicture.of(image).rgb(), new int[] {0x0a141e, 0xc8d2dc}), "RGB");
    image.pixelformat = image_t.PIXEL_FORMAT_BGR;
    Check.that(Arrays.equals(ColorPicture.of(image).rgb(), new int[] {0x1e140a, 0xdcd2c8}), "BGR");
    image.pixelformat = image_t.PIXEL_FORMAT_GRAY;
    Check.that(Arrays.equals(ColorPicture.of(image).rgb(), new int[] {0x0a0a0a, 0x141414}), "gray");
    image.pixelformat = 123;
    Check.refused("pixel format 123", () -> ColorPicture.of(image));
    image.pixelformat = image_t.PIXEL_FORMAT_RGB;
    image.row_stride = 5;
    Check.refused("row stride", () -> ColorPicture.of(image));
  }

  private static byte[] jpeg() throws IOException {
    BufferedImage image = new BufferedImage(16, 8, BufferedImage.TYPE_INT_RGB);
    for (int i = 0; i < 16 * 8; i++) {
      image.setRGB(i % 16, i / 16, 0x2060c0);
    }
    ByteArrayOutputStream bytes = new ByteArrayOutputStream();
    ImageIO.write(image, "jpeg", bytes);
    return bytes.toByteArray();
  }

  // Webcams leave out the usual Huffman tables.
  private static byte[] withoutTables(byte[] jpeg) {
    ByteArrayOutputStream kept = new ByteArrayOutputStream();
    kept.write(jpeg, 0, 2);
    int at = 2;
    while ((jpeg[at + 1] & 0xff) != 0xda) {
      int length = 2 + ((jpeg[at + 2] & 0xff) << 8 | jpeg[at + 3] & 0xff);
      if ((jpeg[at + 1] & 0xff) != 0xc4) {
        kept.write(jpeg, at, length);
      }
      at += length;
    }
    kept.write(jpeg, at, jpeg.length - at);
    return kept.toByteArray();
  }

  private static void checkBlue(byte[] jpeg) {
    image_t image = image(16, 8, 0, jpeg);
    image.pixelformat = image_t.PIXEL_FORMAT_MJPEG;
    for (int color : ColorPicture.of(image).rgb()) {
      Check.near(color >> 16, 0x20, 6);
      Check.near(color >> 8 & 0xff, 0x60, 6);
      Check.near(color & 0xff, 0xc0, 6);
    }
  }

  static void testJpeg() throws Exception {
    checkBlue(jpeg());
    image_t other = image(8, 16, 0, jpeg());
    other.pixelformat = image_t.PIXEL_FORMAT_MJPEG;
    Check.refused("the message says", () -> ColorPicture.of(other));
    image_t cut = image(16, 8, 0, Arrays.copyOf(jpeg(), 30));
    cut.pixelformat = image_t.PIXEL_FORMAT_MJPEG;
    Check.refused("JPEG", () -> ColorPicture.of(cut));
    image_t none = image(16, 8, 0, new byte[0]);
    none.pixelformat = image_t.PIXEL_FORMAT_MJPEG;
    Check.refused("JPEG", () -> ColorPicture.of(none));
  }

  static void testJpegOfAWebcam() throws Exception {
    checkBlue(withoutTables(jpeg()));
  }

  static void testAnImageThatCannotBeShownHidesNoOther() throws Exception {
    images_t message = new images_t();
    image_t foreign = image(5, 3, 10, depthBytes(10));
    foreign.pixelformat = image_t.PIXEL_FORMAT_UYVY;
    message.images = new image_t[] {foreign, image(WIDTH, HEIGHT, 10, depthBytes(10))};
    message.image_types = new short[] {images_t.LEFT, images_t.DEPTH_MM};
    Pictures pictures = Pictures.of(message);
    Check.equal(pictures.shown().size(), 1);
    checkDepth(pictures.shown().get(0));
    Check.that(pictures.leftOut().contains("pixel format"), pictures.leftOut());
    message.image_types[1] = images_t.LEFT;
    Check.refused("pixel format", () -> Pictures.of(message));
    message.images = new image_t[0];
    Check.refused("without an image", () -> Pictures.of(message));
    message.images = new image_t[9];
    Check.refused("9 images", () -> Pictures.of(message));
  }

  static void testSeqIsRead() {
    images_t message = new images_t();
    message.images = new image_t[] {image(5, 3, 10, depthBytes(10))};
    Check.equal(Pictures.seq(message), -1L);
    image_metadata_t seq = new image_metadata_t();
    seq.key = "seq";
    seq.value = new byte[] {1, 2, 0, 0, 0, 0, 0, 0};
    message.images[0].metadata = new image_metadata_t[] {seq};
    Check.equal(Pictures.seq(message), 513L);
    seq.value = new byte[3];
    Check.equal(Pictures.seq(message), -1L);
  }
}
