package vantage.spy;

/** Standard deviations from covariances as messages hold them, row by row. */
final class Deviation {
  private Deviation() {}

  /** deg, of a rotation vector whose covariance (rad^2) begins at `first` of a matrix. */
  static String degrees(double[] matrix, int size, int first) {
    return Text.number(Math.toDegrees(root(matrix, size, first)), 3);
  }

  /** mm, of a position whose covariance (m^2) begins at `first`. */
  static String millimetres(double[] matrix, int size, int first) {
    return Text.number(1000 * root(matrix, size, first), 2);
  }

  // Of three coordinates: the root of the trace, which is the root mean square length.
  private static double root(double[] matrix, int size, int first) {
    double trace = 0;
    for (int i = first; i < first + 3; i++) {
      trace += matrix[i * size + i];
    }
    return Math.sqrt(trace);
  }
}
