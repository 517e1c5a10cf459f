package vantage.spy;

import java.util.ArrayList;
import java.util.List;
import vantage.object_estimate_v3_t;
import vantage.object_estimates_v3_t;
import vantage.orientation_peak_v2_t;

/** OBJECTS as a table: what is known of each object, and how well. */
final class ObjectRows {
  private ObjectRows() {}

  static List<Rows> of(object_estimates_v3_t message, long nowUtime) {
    Rows objects = new Rows(
        message.num_objects + " objects from " + message.num_viewpoints + " viewpoints"
            + (message.finished ? ", finished" : "") + ", age "
            + Text.age(message.utime, nowUtime),
        "object", "model", "state", "views", "age", "pose by", "x y z, m", "w x y z", "± deg",
        "± mm", "rms, mm", "last change, deg", "entropy, nat", "converged", "note");
    Rows peaks = new Rows(
        "Orientations that they may have, the likeliest first",
        "object", "peak", "weight", "spread, deg", "w x y z");
    for (object_estimate_v3_t object : message.objects) {
      addObject(object, Text.age(message.utime, nowUtime), objects);
      for (int i = 0; i < object.num_peaks; i++) {
        orientation_peak_v2_t peak = object.peaks[i];
        peaks.add(
            false,
            name(object),
            Integer.toString(i),
            Text.number(peak.weight, 3),
            Text.number(Math.toDegrees(peak.spread), 2),
            Text.numbers(peak.quat, 4));
      }
    }
    return List.of(objects, peaks);
  }

  private static void addObject(object_estimate_v3_t object, String age, Rows rows) {
    boolean refined = object.refinement == object_estimate_v3_t.REFINED;
    boolean refused = object.refinement == object_estimate_v3_t.REFINEMENT_REFUSED;
    boolean lost = object.state == object_estimate_v3_t.LOST;
    double[] quat = new double[0];
    String angle = "";
    if (refined) {
      quat = object.refined_quat;
      angle = Deviation.degrees(object.refined_covariance, 6, 0);
    } else if (object.num_peaks > 0) {
      quat = object.peaks[0].quat;
      angle = Deviation.degrees(object.peaks[0].covariance, 3, 0);
    }
    List<String> cells = new ArrayList<>();
    cells.add(Integer.toString(object.instance_id));
    cells.add(Text.line(object.model_id));
    cells.add(state(object.state));
    cells.add(Integer.toString(object.num_views));
    cells.add(age);
    cells.add(refined ? "refinement of " + object.refined_views + " images" : "fusion");
    cells.add(Text.numbers(refined ? object.refined_trans : object.trans, 4));
    cells.add(Text.numbers(quat, 4));
    cells.add(angle);
    cells.add(refined
        ? Deviation.millimetres(object.refined_covariance, 6, 3)
        : Deviation.millimetres(object.trans_covariance, 3, 0));
    cells.add(refined ? Text.number(1000 * object.refined_rms, 2) : "");
    cells.add(object.last_change < 0 ? "" : Text.number(Math.toDegrees(object.last_change), 3));
    cells.add(Text.number(object.entropy, 2));
    cells.add(object.converged ? "yes" : "no");
    cells.add(Text.line(object.refinement_note));
    rows.add(lost || refused, cells.toArray(String[]::new));
  }

  private static String name(object_estimate_v3_t object) {
    return object.instance_id + ": " + Text.line(object.model_id);
  }

  private static String state(byte state) {
    return switch (state) {
      case object_estimate_v3_t.TENTATIVE -> "tentative";
      case object_estimate_v3_t.CONFIRMED -> "confirmed";
      case object_estimate_v3_t.LOST -> "lost";
      default -> "state " + state;
    };
  }
}
