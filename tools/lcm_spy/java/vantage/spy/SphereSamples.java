package vantage.spy;

import java.util.HashMap;
import java.util.Map;
import vantage.orientation_histogram_t;

/**
 * Where the orientations of a histogram take a vector (paper section 4.1), gathered in bins of
 * about half a degree so that drawing costs by places, not by cells.
 *
 * @param directions unit vectors
 * @param weights of the directions, above 0
 * @param numIgnored cells of the message that the grid does not have, or without a sound weight
 * @param peak w, x, y, z of the heaviest cell; null when there is none
 * @param peakShare of all weight that the heaviest cell has
 */
record SphereSamples(
    double[][] directions, double[] weights, int numIgnored, double[] peak, double peakShare) {
  private static final double BINS = 128; // By unit of length.

  /** Throws an IllegalArgumentException when k is none of a grid. */
  static void checkGrid(orientation_histogram_t histogram) {
    if (histogram.k < So3Cell.SMALLEST_K || histogram.k > So3Cell.LARGEST_K) {
      throw new IllegalArgumentException("a histogram of k = " + histogram.k + ", expected "
          + So3Cell.SMALLEST_K + " to " + So3Cell.LARGEST_K);
    }
  }

  /** As checkGrid(). @param vector of unit norm */
  static SphereSamples of(orientation_histogram_t histogram, double[] vector) {
    checkGrid(histogram);
    Map<Long, double[]> bins = new HashMap<>(); // Weighted sum of directions, and of weights.
    double[] q = new double[4];
    double[] peak = null;
    double highest = 0;
    double sum = 0;
    int numIgnored = 0;
    for (int i = 0; i < histogram.num_cells; i++) {
      double weight = histogram.weight[i];
      boolean sound = weight >= 0 && weight <= Float.MAX_VALUE;
      if (!sound || !So3Cell.orientation(histogram.k, histogram.cell[i], q)) {
        numIgnored++;
        continue;
      }
      if (weight == 0) {
        continue;
      }
      sum += weight;
      if (weight > highest) {
        highest = weight;
        peak = q.clone();
      }
      double[] at = Vectors.rotate(q, vector);
      double[] bin = bins.computeIfAbsent(binOf(at), key -> new double[4]);
      for (int c = 0; c < 3; c++) {
        bin[c] += weight * at[c];
      }
      bin[3] += weight;
    }
    double[][] directions = new double[bins.size()][];
    double[] weights = new double[bins.size()];
    int n = 0;
    for (double[] bin : bins.values()) {
      weights[n] = bin[3];
      directions[n++] = Vectors.unit(bin[0], bin[1], bin[2]);
    }
    return new SphereSamples(directions, weights, numIgnored, peak, sum > 0 ? highest / sum : 0);
  }

  private static long binOf(double[] at) {
    long bin = 0;
    for (int c = 0; c < 3; c++) {
      bin = bin << 20 | (long) Math.floor((at[c] + 1) * BINS);
    }
    return bin;
  }
}
