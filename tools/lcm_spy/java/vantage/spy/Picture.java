package vantage.spy;

/**
 * An image ready to be shown.
 *
 * @param title what it is
 * @param rgb width * height colors, 0xRRGGBB
 * @param depth null for a color image
 */
record Picture(String title, int width, int height, int[] rgb, Depth depth) {
  /**
   * What a depth image has beside colors.
   *
   * @param millimetres unsigned, 0: no measurement
   * @param scaleNear mm, the value at the light end of the color scale
   * @param scaleFar mm, the value at its dark end
   */
  record Depth(short[] millimetres, int numValid, int nearest, int farthest, int scaleNear,
      int scaleFar) {}

  /** A line about the whole of it. */
  String describe() {
    String text = title + ", " + width + " x " + height + " px";
    if (depth == null) {
      return text;
    }
    String share = Text.number(100.0 * depth.numValid / (width * (double) height), 1);
    return depth.numValid == 0
        ? text + ", no measurement"
        : text + ", " + share + " % measured, " + depth.nearest + " to " + depth.farthest + " mm";
  }

  /** A line about one pixel; empty outside. */
  String describePixel(int u, int v) {
    if (u < 0 || v < 0 || u >= width || v >= height) {
      return "";
    }
    String at = "(" + u + ", " + v + "): ";
    if (depth == null) {
      int color = rgb[v * width + u];
      return at + (color >> 16 & 0xff) + " " + (color >> 8 & 0xff) + " " + (color & 0xff);
    }
    int millimetres = depth.millimetres[v * width + u] & 0xffff;
    return at + (millimetres == 0 ? "no measurement" : millimetres + " mm");
  }
}
