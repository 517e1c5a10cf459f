package vantage.spy;

import java.util.Locale;

/** Numbers and strings of messages, for people. Whatever is in them, it stays one short line. */
final class Text {
  private static final int MAX_LENGTH = 200;

  private Text() {}

  /** With so many decimals; "nan" and "inf" where it is none. */
  static String number(double value, int decimals) {
    if (Double.isNaN(value)) {
      return "nan";
    }
    if (Double.isInfinite(value)) {
      return value > 0 ? "inf" : "-inf";
    }
    if (Math.abs(value) >= 1e9) {
      return String.format(Locale.ROOT, "%.3e", value);
    }
    return String.format(Locale.ROOT, "%." + decimals + "f", value);
  }

  /** Numbers with a space between them. */
  static String numbers(double[] values, int decimals) {
    StringBuilder text = new StringBuilder();
    for (double value : values) {
      text.append(text.length() == 0 ? "" : " ").append(number(value, decimals));
    }
    return text.toString();
  }

  /** Seconds in the unit that suits. */
  static String duration(double seconds) {
    double size = Math.abs(seconds);
    if (!(size < 1e15)) {
      return number(seconds, 0) + " s";
    }
    if (size < 99.95) {
      return number(seconds, 1) + " s";
    }
    if (size < 5970) {
      return number(seconds / 60, 0) + " min";
    }
    return size < 2 * 86400 ? number(seconds / 3600, 0) + " h" : number(seconds / 86400, 0) + " d";
  }

  /** From a message's utime to now. */
  static String age(long utime, long nowUtime) {
    return duration(1e-6 * ((double) nowUtime - (double) utime));
  }

  /** A string from a message: clipped, without control characters. */
  static String line(String text) {
    if (text == null) {
      return "";
    }
    String clipped = text.length() > MAX_LENGTH ? text.substring(0, MAX_LENGTH) + "…" : text;
    return clipped.replaceAll("\\p{Cntrl}", " ");
  }
}
