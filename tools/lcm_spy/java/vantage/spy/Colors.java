package vantage.spy;

/** Colors as 0xRRGGBB; the scales are those of the project's reports. */
final class Colors {
  static final int NO_DEPTH = 0x2e323a;
  private static final int[] DEPTH = {0xecf0cd, 0x9ed3b9, 0x54acac, 0x347c9a, 0x2e4e7a, 0x24264e};
  private static final int[] DENSITY = {0xe9eaee, 0xbacee8, 0x70a0da, 0x2e60b8, 0x0e1e68};

  private Colors() {}

  /** From near (0, light) to far (1, dark); clamped. */
  static int depth(double t) {
    return interpolate(DEPTH, t);
  }

  /** From none (0, pale grey) to most (1, deep blue); clamped. */
  static int density(double t) {
    return interpolate(DENSITY, t);
  }

  /** A share of b in [0, 1], the rest of a. */
  static int mix(int a, int b, double share) {
    int mixed = 0;
    for (int shift = 16; shift >= 0; shift -= 8) {
      int from = a >> shift & 0xff;
      int to = b >> shift & 0xff;
      mixed |= (int) Math.round(from + share * (to - from)) << shift;
    }
    return mixed;
  }

  private static int interpolate(int[] stops, double t) {
    if (!(t > 0)) {
      return stops[0];
    }
    if (t >= 1) {
      return stops[stops.length - 1];
    }
    double place = t * (stops.length - 1);
    int index = (int) place;
    return mix(stops[index], stops[index + 1], place - index);
  }
}
