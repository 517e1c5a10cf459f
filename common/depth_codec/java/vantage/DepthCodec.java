package vantage;

import java.io.BufferedOutputStream;
import java.io.IOException;
import java.io.OutputStream;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.zip.CRC32C;

/**
 * Decoder of Vantage's depth codec (docs/depth-codec.md): one payload, one image. By itself it writes
 * FILE.pgm, 16 bits a pixel, for each FILE that it is given.
 */
public final class DepthCodec {
  /** The bytes are no image of the depth codec, or a damaged one. */
  public static final class CorruptException extends IOException {
    private static final long serialVersionUID = 1;

    CorruptException(String message) {
      super(message);
    }
  }

  /** Pixels row by row, 0 where there is no measurement; as unsigned: pixels[i] & 0xffff. */
  public record Image(int width, int height, short[] pixels) {}

  private static final int STRIPS = 32;
  private static final int BANDS = 2;
  private static final int LANES = STRIPS * BANDS;
  private static final int MAX_SIDE = 4096;
  private static final int SYMBOLS = 8;
  private static final int CONTEXTS = 16;
  private static final int BUCKETS = 15;
  private static final int SCALE_BITS = 14;
  private static final int SCALE = 1 << SCALE_BITS;
  private static final long STATE_LOW = 1 << 16;
  private static final int BELOW = 0;
  private static final int ZERO = 3;
  private static final int ABOVE = 6;
  private static final int INVALID = 7;

  private static final int[] GRADIENT_CONTEXTS = {
    7, 7, 6, 6, 14, 7, 14, 14, 14, 14, 4, 7, 14, 14, 14, 7, 15, 14, 14, 14, 14, 14, 14, 14, 14,
    7, 7, 6, 6, 14, 7, 9, 12, 7, 14, 4, 3, 15, 5, 14, 7, 9, 5, 12, 14, 14, 14, 14, 14, 14,
    7, 4, 6, 6, 14, 4, 3, 10, 12, 11, 6, 2, 1, 9, 14, 7, 9, 5, 12, 14, 14, 14, 14, 12, 14,
    7, 4, 6, 6, 14, 4, 3, 10, 12, 14, 6, 4, 8, 12, 14, 6, 7, 15, 10, 14, 14, 14, 14, 12, 12,
    7, 7, 6, 14, 14, 6, 7, 4, 10, 14, 6, 6, 10, 12, 14, 6, 6, 12, 10, 12, 14, 14, 14, 12, 10
  };
  private static final int[] VALIDITY_CONTEXTS = {
    0, 11, 11, 11, 13, 13, 13, 7, 13, 11, 11, 11, 13, 13, 13, 0
  };

  private final ByteBuffer data;
  private final int width;
  private final int height;
  private final int columns; // Of a strip.
  private final int rows; // Of the upper band.
  private int[] values; // By rank.
  private final int[][] start = new int[CONTEXTS][];
  private int[] bucketStart;
  private final long[] states = new long[LANES];

  private DepthCodec(ByteBuffer data, int width, int height) {
    this.data = data;
    this.width = width;
    this.height = height;
    columns = (width + STRIPS - 1) / STRIPS;
    rows = (height + BANDS - 1) / BANDS;
  }

  /** The image of a payload. */
  public static Image decode(byte[] payload) throws CorruptException {
    if (payload.length < 13) {
      throw new CorruptException(payload.length + " bytes, expected a header of 13");
    }
    ByteBuffer data = ByteBuffer.wrap(payload).order(ByteOrder.LITTLE_ENDIAN);
    if (data.getInt(0) != 0x01434456) {
      throw new CorruptException("it does not begin with \"VDC\" and version 1");
    }
    CRC32C checksum = new CRC32C();
    checksum.update(payload, 8, payload.length - 8);
    if ((int) checksum.getValue() != data.getInt(4)) {
      throw new CorruptException("its checksum does not fit its bytes");
    }
    int width = data.getShort(8) & 0xffff;
    int height = data.getShort(10) & 0xffff;
    if (width < 1 || width > MAX_SIDE || height < 1 || height > MAX_SIDE) {
      throw new CorruptException(
          "it is " + width + " x " + height + " px, expected sides of 1 to " + MAX_SIDE);
    }
    int mode = payload[12] & 0xff;
    data.position(13);
    if (mode == 0) {
      return decodeStored(data, width, height);
    }
    if (mode == 1) {
      return new DepthCodec(data, width, height).decodeCoded();
    }
    if (mode == 2) {
      return decodeWindow(data, width, height);
    }
    throw new CorruptException("its mode is " + mode + ", expected 0 to 2");
  }

  private static Image decodeWindow(ByteBuffer data, int width, int height)
      throws CorruptException {
    if (data.remaining() < 8) {
      throw new CorruptException("the window is cut off");
    }
    int left = data.getShort() & 0xffff;
    int top = data.getShort() & 0xffff;
    int wide = data.getShort() & 0xffff;
    int high = data.getShort() & 0xffff;
    if (wide == 0 || high == 0 || left + wide > width || top + high > height) {
      throw new CorruptException(
          "its window is " + wide + " x " + high + " px at (" + left + ", " + top + ")");
    }
    Image window = new DepthCodec(data, wide, high).decodeCoded();
    short[] pixels = new short[width * height];
    for (int v = 0; v < high; ++v) {
      System.arraycopy(window.pixels(), v * wide, pixels, (top + v) * width + left, wide);
    }
    return new Image(width, height, pixels);
  }

  private static Image decodeStored(ByteBuffer data, int width, int height)
      throws CorruptException {
    if (data.remaining() != 2 * width * height) {
      throw new CorruptException(
          data.remaining() + " bytes of pixels, expected " + 2 * width * height);
    }
    short[] pixels = new short[width * height];
    data.asShortBuffer().get(pixels);
    return new Image(width, height, pixels);
  }

  private Image decodeCoded() throws CorruptException {
    readPalette();
    for (int context = 0; context < CONTEXTS; ++context) {
      start[context] = readStarts(SYMBOLS);
    }
    bucketStart = readStarts(BUCKETS);
    if (data.remaining() < 4 * LANES || data.remaining() % 2 != 0) {
      throw new CorruptException("the states are cut off");
    }
    for (int lane = 0; lane < LANES; ++lane) {
      states[lane] = data.getInt() & 0xffffffffL;
      if (states[lane] < STATE_LOW) {
        throw new CorruptException("a state is out of range");
      }
    }
    short[] pixels = decodeRows();
    for (long state : states) {
      if (state != STATE_LOW || data.hasRemaining()) {
        throw new CorruptException("states or words are left over");
      }
    }
    return new Image(width, height, pixels);
  }

  private void readPalette() throws CorruptException {
    need(2);
    int count = data.getShort() & 0xffff;
    values = new int[count + 1];
    if (count == 0) {
      return;
    }
    need(5);
    int value = data.getShort() & 0xffff;
    int factor = data.getShort() & 0xffff;
    int k = data.get() & 0xff;
    if (value == 0 || factor == 0 || k > 15) {
      throw new CorruptException(
          "a palette from " + value + " in steps of " + factor + " with " + k + " bits");
    }
    values[1] = value;
    int begin = data.position();
    int bit = 0;
    for (int i = 2; i <= count; ++i) {
      int step = 0;
      while (bitAt(begin, bit++) == 1) {
        step += 1 << k;
        if (step >= 65536) {
          throw new CorruptException("the palette is damaged");
        }
      }
      for (int j = 0; j < k; ++j) {
        step += bitAt(begin, bit++) << j;
      }
      long next = value + (long) factor * (step + 1L);
      if (next >= 65536) {
        throw new CorruptException("the palette goes beyond 65535");
      }
      value = (int) next;
      values[i] = value;
    }
    data.position(begin + (bit + 7) / 8);
  }

  private int bitAt(int begin, int bit) throws CorruptException {
    if (begin + bit / 8 >= data.limit()) {
      throw new CorruptException("the palette is cut off");
    }
    return (data.get(begin + bit / 8) >> (bit % 8)) & 1;
  }

  private void need(int bytes) throws CorruptException {
    if (data.remaining() < bytes) {
      throw new CorruptException("it is cut off");
    }
  }

  /** Sums of the frequencies before each symbol, and of all. */
  private int[] readStarts(int symbols) throws CorruptException {
    need(symbols);
    int leftOut = data.get() & 0xff;
    int[] frequency = new int[symbols];
    int left = SCALE;
    for (int i = 0; i < symbols; ++i) {
      if (i == leftOut) {
        continue;
      }
      int code = leftOut < symbols ? data.get() & 0xff : 56;
      if (code > 55) {
        throw new CorruptException("the frequencies are damaged");
      }
      frequency[i] = ((4 + (code & 3)) << (code >> 2)) >> 2;
      left -= frequency[i];
    }
    if (left < 1) {
      throw new CorruptException("the frequencies are damaged");
    }
    frequency[leftOut] = left;
    int[] starts = new int[symbols + 1];
    for (int i = 0; i < symbols; ++i) {
      starts[i + 1] = starts[i] + frequency[i];
    }
    return starts;
  }

  // Ranks and flags have a column more than the strips on each side, which is outside.
  private short[] decodeRows() throws CorruptException {
    short[] pixels = new short[width * height];
    int padded = STRIPS * columns + 2;
    short[][] above = new short[BANDS][padded];
    boolean[][] aboveValid = new boolean[BANDS][padded];
    short[][] ranks = new short[BANDS][padded];
    boolean[][] valid = new boolean[BANDS][padded];
    for (int row = 0; row < rows; ++row) {
      int bands = rows + row < height ? BANDS : 1;
      for (int column = 0; column < columns; ++column) {
        for (int band = 0; band < bands; ++band) {
          decodeStep(band, column, above[band], aboveValid[band], ranks[band], valid[band]);
        }
      }
      for (int band = 0; band < bands; ++band) {
        int v = row + band * rows;
        for (int u = 0; u < width; ++u) {
          int rank = valid[band][u + 1] ? ranks[band][u + 1] & 0xffff : 0;
          pixels[v * width + u] = (short) values[rank];
        }
      }
      short[][] otherRanks = above;
      above = ranks;
      ranks = otherRanks;
      boolean[][] otherValid = aboveValid;
      aboveValid = valid;
      valid = otherValid;
    }
    return pixels;
  }

  /** A column of all strips of a band. */
  private void decodeStep(
      int band, int column, short[] above, boolean[] aboveValid, short[] ranks, boolean[] valid)
      throws CorruptException {
    int[] symbols = new int[STRIPS];
    for (int strip = 0; strip < STRIPS; ++strip) {
      int u = strip * columns + column + 1;
      int context = contextAt(u, column == 0, above, aboveValid, ranks, valid);
      symbols[strip] = decodeSymbol(STRIPS * band + strip, start[context]);
    }
    for (int strip = 0; strip < STRIPS; ++strip) {
      int u = strip * columns + column + 1;
      int symbol = symbols[strip];
      int residual = symbol - ZERO;
      if (symbol == BELOW || symbol == ABOVE) {
        int distance = decodeDistance(STRIPS * band + strip) + 2;
        residual = symbol == ABOVE ? distance : -distance;
      }
      short north = above[u];
      short northWest = above[u - 1];
      short west = column == 0 ? northWest : ranks[u - 1];
      int plane = (short) (west + north - northWest);
      int predicted =
          Math.max(Math.min(west, north), Math.min(plane, Math.max(west, north)));
      valid[u] = symbol != INVALID;
      ranks[u] = (short) (valid[u] ? predicted + residual : predicted);
      int rank = ranks[u] & 0xffff;
      if (valid[u] && (rank == 0 || rank >= values.length)) {
        throw new CorruptException("a rank is beyond the palette");
      }
    }
  }

  private static int contextAt(
      int u,
      boolean first,
      short[] above,
      boolean[] aboveValid,
      short[] ranks,
      boolean[] valid) {
    short north = above[u];
    short northWest = above[u - 1];
    short west = first ? northWest : ranks[u - 1];
    boolean westValid = first ? aboveValid[u - 1] : valid[u - 1];
    int flags =
        (westValid ? 1 : 0)
            + (aboveValid[u] ? 2 : 0)
            + (aboveValid[u - 1] ? 4 : 0)
            + (aboveValid[u + 1] ? 8 : 0);
    if (flags != 15) {
      return VALIDITY_CONTEXTS[flags];
    }
    return GRADIENT_CONTEXTS[
        clamped(west - northWest)
            + 5 * clamped(north - northWest)
            + 25 * clamped(above[u + 1] - north)];
  }

  private static int clamped(int step) {
    return Math.max(-2, Math.min(2, (short) step)) + 2;
  }

  private int decodeSymbol(int lane, int[] starts) throws CorruptException {
    long x = states[lane];
    int slot = (int) (x & (SCALE - 1));
    int symbol = 0;
    while (starts[symbol + 1] <= slot) {
      ++symbol;
    }
    long frequency = starts[symbol + 1] - starts[symbol];
    states[lane] = refilled(frequency * (x >> SCALE_BITS) + slot - starts[symbol]);
    return symbol;
  }

  private int decodeDistance(int lane) throws CorruptException {
    int bucket = decodeSymbol(lane, bucketStart);
    long x = states[lane];
    states[lane] = refilled(x >> bucket);
    return (1 << bucket) | (int) (x & ((1 << bucket) - 1));
  }

  private long refilled(long x) throws CorruptException {
    if (x >= STATE_LOW) {
      return x;
    }
    if (data.remaining() < 2) {
      throw new CorruptException("the words end too early");
    }
    return (x << 16) | (data.getShort() & 0xffff);
  }

  /** FILE... */
  public static void main(String[] files) {
    boolean failed = files.length == 0;
    if (failed) {
      System.err.println("usage: vantage.DepthCodec FILE...    writes FILE.pgm for each payload");
    }
    for (String file : files) {
      try {
        writePgm(decode(Files.readAllBytes(Path.of(file))), Path.of(file + ".pgm"));
      } catch (IOException error) {
        System.err.println(file + ": " + error.getMessage());
        failed = true;
      }
    }
    System.exit(failed ? 1 : 0);
  }

  private static void writePgm(Image image, Path file) throws IOException {
    try (OutputStream out = new BufferedOutputStream(Files.newOutputStream(file))) {
      String head = "P5\n" + image.width() + " " + image.height() + "\n65535\n";
      out.write(head.getBytes(StandardCharsets.US_ASCII));
      for (short pixel : image.pixels()) {
        out.write(pixel >> 8);
        out.write(pixel);
      }
    }
  }
}
