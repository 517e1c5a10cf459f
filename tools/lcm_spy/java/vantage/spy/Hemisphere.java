package vantage.spy;

import java.util.Arrays;

/**
 * Half of the unit sphere as it is seen from far away, z of the world up, and the density of
 * samples on it. As tools/support/sphere_renderer draws it in reports.
 */
final class Hemisphere {
  private static final double KERNEL = 0.035; // rad, standard deviation of the smoothing
  private static final double REACH = 3 * KERNEL;
  private static final double GRID = Math.toRadians(30);
  private static final double[] LIGHT = {-0.35, 0.45, 0.82};
  private static final int LINE = 0x5a6270;
  private static final int SHADOW = 0x282c34;

  private final double[] right;
  private final double[] up;
  private final double[] towards;
  private final int radius;
  private final double[] density; // By pixel of a square of 2 radius + 1.

  /** Seen from `towards`, a unit vector; the picture is 2 radius + 1 px wide and high. */
  Hemisphere(double[] towards, int radius) {
    double[] across = Vectors.cross(new double[] {0, 0, 1}, towards);
    right = Vectors.dot(across, across) < 1e-12
        ? new double[] {1, 0, 0} : Vectors.unit(across);
    up = Vectors.cross(towards, right);
    this.towards = towards;
    this.radius = radius;
    density = new double[size() * size()];
  }

  int size() {
    return 2 * radius + 1;
  }

  /** A direction in the view's axes: right, up, towards the viewer. */
  double[] toView(double[] direction) {
    return new double[] {
      Vectors.dot(right, direction), Vectors.dot(up, direction), Vectors.dot(towards, direction)
    };
  }

  /** px; behind the sphere's rim when the third of toView is below 0. */
  double columnOf(double[] direction) {
    return radius * (1 + Vectors.dot(right, direction));
  }

  double rowOf(double[] direction) {
    return radius * (1 - Vectors.dot(up, direction));
  }

  void add(SphereSamples samples) {
    for (int i = 0; i < samples.weights().length; i++) {
      add(toView(samples.directions()[i]), samples.weights()[i]);
    }
  }

  private void add(double[] at, double weight) {
    if (at[2] < -Math.sin(REACH)) {
      return;
    }
    double column = radius * (1 + at[0]);
    double row = radius * (1 - at[1]);
    int span = (int) Math.ceil(radius * REACH);
    int left = Math.max(0, (int) column - span);
    int top = Math.max(0, (int) row - span);
    for (int v = top; v <= Math.min(size() - 1, row + span); v++) {
      for (int u = left; u <= Math.min(size() - 1, column + span); u++) {
        double x = (u - radius) / (double) radius;
        double y = (radius - v) / (double) radius;
        double rest = 1 - x * x - y * y;
        if (rest < 0) {
          continue;
        }
        double dx = x - at[0];
        double dy = y - at[1];
        double dz = Math.sqrt(rest) - at[2];
        double chord2 = dx * dx + dy * dy + dz * dz; // angle^2 to within 1 %
        if (chord2 <= REACH * REACH) {
          density[v * size() + u] += weight * Math.exp(-0.5 * chord2 / (KERNEL * KERNEL));
        }
      }
    }
  }

  double highest() {
    return Arrays.stream(density).max().orElse(0);
  }

  /** Colors row by row, `background` outside of the disk; `highest` is the darkest. */
  int[] paint(double highest, int background) {
    int[] rgb = new int[size() * size()];
    double[] point = new double[3];
    for (int v = 0; v < size(); v++) {
      for (int u = 0; u < size(); u++) {
        point[0] = (u - radius) / (double) radius;
        point[1] = (radius - v) / (double) radius;
        double rest = 1 - point[0] * point[0] - point[1] * point[1];
        int pixel = v * size() + u;
        if (rest < 0) {
          rgb[pixel] = background;
          continue;
        }
        point[2] = Math.sqrt(rest);
        rgb[pixel] = surface(point, highest > 0 ? density[pixel] / highest : 0);
      }
    }
    return rgb;
  }

  private int surface(double[] point, double share) {
    int color = Colors.density(share);
    if (isOnGraticule(point)) {
      color = Colors.mix(color, LINE, 0.22);
    }
    double light = 0.8 + 0.2 * Vectors.dot(LIGHT, point);
    return Colors.mix(SHADOW, color, Math.min(1, Math.max(0, light)));
  }

  private boolean isOnGraticule(double[] point) {
    double[] world = new double[3];
    for (int i = 0; i < 3; i++) {
      world[i] = right[i] * point[0] + up[i] * point[1] + towards[i] * point[2];
    }
    double latitude = Math.asin(Math.min(1, Math.max(-1, world[2])));
    double longitude = Math.atan2(world[1], world[0]);
    double offParallel = Math.abs(Math.IEEEremainder(latitude, GRID));
    double offMeridian =
        Math.abs(Math.IEEEremainder(longitude, GRID)) * Math.hypot(world[0], world[1]);
    return Math.min(offParallel, offMeridian) < 0.9 / radius / Math.max(point[2], 0.25);
  }
}
