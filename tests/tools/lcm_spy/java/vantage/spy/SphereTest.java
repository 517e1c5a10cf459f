package vantage.spy;

import java.util.Random;
import vantage.orientation_histogram_t;

/** Cells become orientations, orientations places on a sphere, places dark pixels. */
public final class SphereTest {
  private static final double[] X = {1, 0, 0};

  private SphereTest() {}

  public static void main(String[] arguments) throws IllegalAccessException {
    Check.runAll(SphereTest.class);
  }

  // Table 1 of the paper.
  static void testTheGridHasThePapersCells() {
    int[][] expected = {{8, 8480}, {16, 68416}};
    for (int[] row : expected) {
      int k = row[0];
      int valid = 0;
      double[] q = new double[4];
      for (int cell = 0; cell < 8 * k * k * k * k; cell++) {
        valid += So3Cell.orientation(k, cell, q) ? 1 : 0;
      }
      Check.equal(valid, row[1]);
    }
  }

  static void testACellsOrientationLiesInTheCell() {
    Random random = new Random(1);
    for (int k : new int[] {8, 64, 128}) {
      int inside = 0;
      for (int i = 0; i < 1000; i++) {
        double[] q = randomOrientation(random);
        double[] found = new double[4];
        Check.that(So3Cell.orientation(k, cellOf(k, q), found), "no valid cell at an orientation");
        Check.near(Vectors.dot(found, found), 1, 1e-12);
        double angle = 2 * Math.acos(Math.min(1, Math.abs(Vectors.dot(q, found))));
        Check.that(angle <= 2 * 2.0 / k, "the cell of k = " + k + " is " + angle + " rad away");
        inside += cellOf(k, found) == cellOf(k, q) ? 1 : 0;
      }
      Check.that(inside > 900, inside + " of 1000 within their own cell");
    }
  }

  static void testCellsOutsideAreNone() {
    double[] q = new double[4];
    for (int cell : new int[] {-1, Integer.MIN_VALUE, 8 * 4096, Integer.MAX_VALUE}) {
      Check.that(!So3Cell.orientation(8, cell, q), "cell " + cell);
    }
    for (int k : new int[] {-5, 0, 1, 129, Integer.MAX_VALUE}) {
      Check.that(!So3Cell.orientation(k, 0, q), "k = " + k);
    }
  }

  static void testRotateIsRotation() {
    double half = Math.sqrt(0.5);
    double[] aboutZ = {half, 0, 0, half};
    double[] turned = Vectors.rotate(aboutZ, X);
    Check.near(turned[0], 0, 1e-15);
    Check.near(turned[1], 1, 1e-15);
    Random random = new Random(2);
    for (int i = 0; i < 100; i++) {
      double[] q = randomOrientation(random);
      double[] opposite = {-q[0], -q[1], -q[2], -q[3]};
      double[] a = Vectors.rotate(q, Vectors.unit(1, 2, 3));
      double[] b = Vectors.rotate(opposite, Vectors.unit(1, 2, 3));
      Check.near(Vectors.dot(a, b), 1, 1e-12);
      double[] axis = Vectors.unit(q[1], q[2], q[3]);
      Check.near(Vectors.dot(Vectors.rotate(q, axis), axis), 1, 1e-12);
    }
  }

  static void testSamplesKeepTheWeightThatIsSound() throws Exception {
    double[] q = Vectors.unit(0.6, -0.3, 0.5, 0.2);
    orientation_histogram_t histogram = new orientation_histogram_t();
    histogram.k = 32;
    histogram.cell = new int[] {cellOf(32, q), cellOf(32, q), -7, cellOf(32, q), 0, cellOf(32, q)};
    histogram.weight = new float[] {2, 1, 9, Float.NaN, 9, Float.POSITIVE_INFINITY};
    histogram.num_cells = 6;
    SphereSamples samples = SphereSamples.of(histogram, X);
    Check.equal(samples.numIgnored(), 4);
    Check.equal(samples.weights().length, 1);
    Check.near(samples.weights()[0], 3, 1e-12);
    Check.near(samples.peakShare(), 2 / 3.0, 1e-12);
    Check.that(Vectors.dot(samples.directions()[0], Vectors.rotate(q, X)) > 0.99, "elsewhere");
    histogram.k = 1000;
    Check.refused("k = 1000", () -> SphereSamples.of(histogram, X));
    histogram.k = 32;
    histogram.num_cells = 0;
    Check.equal(SphereSamples.of(histogram, X).weights().length, 0);
  }

  // A single direction is darkest where the projection puts it, on the half that faces it.
  static void testTheDarkestPixelIsWhereTheDirectionIs() {
    Random random = new Random(3);
    int radius = 100;
    for (int i = 0; i < 30; i++) {
      double[] towards = Vectors.unit(
          random.nextGaussian(), random.nextGaussian(), random.nextGaussian());
      double[] direction = Vectors.unit(
          random.nextGaussian(), random.nextGaussian(), random.nextGaussian());
      double depth = Vectors.dot(towards, direction);
      Hemisphere half = new Hemisphere(towards, radius);
      half.add(new SphereSamples(new double[][] {direction}, new double[] {1}, 0, null, 1));
      if (depth < -0.2) {
        Check.near(half.highest(), 0, 0);
      }
      if (depth < 0.2) {
        continue;
      }
      Check.near(half.highest(), 1, 0.05);
      int[] rgb = half.paint(half.highest(), 0xffffff);
      int column = (int) Math.round(half.columnOf(direction));
      int row = (int) Math.round(half.rowOf(direction));
      Check.that(lightness(rgb[row * half.size() + column]) < 300, "no dark pixel there");
      int elsewhere = 0;
      for (int color : rgb) {
        elsewhere += lightness(color) < 300 ? 1 : 0;
      }
      Check.that(elsewhere < 200, elsewhere + " dark pixels");
    }
  }

  static void testUpIsUpAndNothingIsBlank() {
    Hemisphere half = new Hemisphere(Vectors.unit(1, 1, 1), 50);
    Check.that(half.rowOf(new double[] {0, 0, 1}) < 50, "z is not up");
    Check.that(half.columnOf(X) < 50 && half.columnOf(new double[] {0, 1, 0}) > 50, "mirrored");
    int[] rgb = half.paint(half.highest(), 0x010203);
    Check.equal(rgb[0], 0x010203);
    Check.that(rgb[50 * 101 + 30] != 0x010203, "no disk");
    Hemisphere fromAbove = new Hemisphere(new double[] {0, 0, 1}, 50);
    Check.that(fromAbove.columnOf(X) == 100, "seen from above x is not on the right");
  }

  private static int lightness(int rgb) {
    return (rgb >> 16 & 0xff) + (rgb >> 8 & 0xff) + (rgb & 0xff);
  }

  private static double[] randomOrientation(Random random) {
    return Vectors.unit(random.nextGaussian(), random.nextGaussian(), random.nextGaussian(),
        random.nextGaussian());
  }

  // As the grid is documented: x, y, z in [-1, 1] in 2k parts, w in [0, 1] in k; w runs fastest.
  private static int cellOf(int k, double[] q) {
    double sign = q[0] < 0 ? -1 : 1;
    int[] index = new int[4];
    for (int i = 0; i < 4; i++) {
      double low = i == 0 ? 0 : -1;
      int parts = i == 0 ? k : 2 * k;
      index[i] = Math.min(parts - 1, (int) Math.floor((sign * q[i] - low) * k));
    }
    return ((index[1] * 2 * k + index[2]) * 2 * k + index[3]) * k + index[0];
  }
}
