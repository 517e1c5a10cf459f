package vantage.spy;

/**
 * The cells of the orientation histogram (docs/fusion.md): x, y, z in [-1, 1] in 2k parts, w in [0,
 * 1] in k; the cells that meet the unit sphere count. The grid's own representative of a cell is
 * the centroid of the patch of the sphere inside it; for a picture the middle of the cell,
 * normalized, is near enough: both lie in the same cell, 1/k wide.
 */
final class So3Cell {
  static final int SMALLEST_K = 2;
  static final int LARGEST_K = 128;

  private So3Cell() {}

  /** Puts w, x, y, z of a cell's orientation into `q`; false when the grid has no such cell. */
  static boolean orientation(int k, int cell, double[] q) {
    if (k < SMALLEST_K || k > LARGEST_K || cell < 0 || cell >= 8L * k * k * k * k) {
      return false;
    }
    int w = cell % k;
    int rest = cell / k;
    int[] lower = {w, rest / (4 * k * k) - k, rest / (2 * k) % (2 * k) - k, rest % (2 * k) - k};
    long nearest = 0; // Squared distances of the corners from 0, in cells.
    long farthest = 0;
    double norm = 0;
    for (int i = 0; i < 4; i++) {
      long inner = lower[i] >= 0 ? lower[i] : -1 - lower[i];
      nearest += inner * inner;
      farthest += (inner + 1) * (inner + 1);
      q[i] = lower[i] + 0.5;
      norm += q[i] * q[i];
    }
    norm = Math.sqrt(norm);
    for (int i = 0; i < 4; i++) {
      q[i] /= norm;
    }
    return nearest <= (long) k * k && (long) k * k <= farthest;
  }
}
