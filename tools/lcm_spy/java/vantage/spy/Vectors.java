package vantage.spy;

/** What little there is to do with 3-vectors and quaternions (w, x, y, z). */
final class Vectors {
  private Vectors() {}

  /** q v q*; q has unit norm. */
  static double[] rotate(double[] q, double[] v) {
    double[] axis = {q[1], q[2], q[3]};
    double[] once = cross(axis, v);
    double[] twice = cross(axis, once);
    double[] rotated = new double[3];
    for (int i = 0; i < 3; i++) {
      rotated[i] = v[i] + 2 * (q[0] * once[i] + twice[i]);
    }
    return rotated;
  }

  static double[] cross(double[] a, double[] b) {
    return new double[] {
      a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    };
  }

  static double dot(double[] a, double[] b) {
    double sum = 0;
    for (int i = 0; i < a.length; i++) {
      sum += a[i] * b[i];
    }
    return sum;
  }

  static double[] unit(double... v) {
    double norm = Math.sqrt(dot(v, v));
    double[] unit = new double[v.length];
    for (int i = 0; i < v.length; i++) {
      unit[i] = v[i] / norm;
    }
    return unit;
  }
}
