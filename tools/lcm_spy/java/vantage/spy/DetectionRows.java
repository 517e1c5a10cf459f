package vantage.spy;

import java.util.List;
import vantage.detection_v2_t;
import vantage.detections_v2_t;

/** DETECTIONS_NAME as a table: the hypotheses of one image. */
final class DetectionRows {
  private DetectionRows() {}

  static List<Rows> of(detections_v2_t message, long nowUtime) {
    Rows rows = new Rows(
        message.num_detections + " hypotheses of " + message.num_clusters + " segments by "
            + Text.line(message.estimator) + " in image " + message.image_seq + " of "
            + Text.line(message.camera) + ", computed in " + Text.duration(message.compute_time)
            + ", age " + Text.age(message.utime, nowUtime),
        "segment", "model", "score", "inliers", "rms, mm", "± deg", "± mm", "x y z in camera, m",
        "w x y z in camera", "at border", "age");
    for (detection_v2_t detection : message.detections) {
      rows.add(
          false,
          Integer.toString(detection.cluster),
          Text.line(detection.model_id),
          Text.number(detection.verification_score, 3),
          Text.number(detection.inlier_fraction, 3),
          Text.number(1000 * Math.sqrt(detection.mse), 2),
          Deviation.degrees(detection.covariance, 6, 0),
          Deviation.millimetres(detection.covariance, 6, 3),
          Text.numbers(detection.trans, 4),
          Text.numbers(detection.quat, 4),
          detection.touches_border ? "yes" : "no",
          Text.age(message.utime, nowUtime));
    }
    return List.of(rows);
  }
}
