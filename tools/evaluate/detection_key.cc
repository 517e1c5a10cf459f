#include "tools/evaluate/detection_key.h"

#include <array>
#include <charconv>
#include <concepts>
#include <cstring>

#include "common/format.h"
#include "tools/evaluate/detection_hash.h"

// Parameters are taken apart by structured bindings: a new one does not compile until it is listed.

namespace vantage {
namespace {

class KeyText {
 public:
  template <class... Values>
  void Line(const char* name, const Values&... values) {
    text_ += name;
    (Add(values), ...);
    text_ += '\n';
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  void Add(const std::string& value) { text_ += " " + value; }
  void Add(bool value) { text_ += value ? " on" : " off"; }
  void Add(const DepthNoise& noise) {
    const auto& [axial_base, axial_quadratic, axial_offset, lateral_px] = noise;
    for (const double value : {axial_base, axial_quadratic, axial_offset, lateral_px}) Add(value);
  }
  // Shortest text that reads back as the same number.
  template <class Number>
  requires(std::integral<Number> || std::floating_point<Number>) void Add(Number value) {
    std::array<char, 32> digits{};
    text_ += ' ';
    text_.append(digits.data(),
                 std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
  }

  std::string text_;
};

uint64_t HashSamples(const ObjectModel& model) {
  uint64_t hash = Fnv1a({});
  for (const SurfacePoint& point : model.samples) {
    for (const Eigen::Vector3f* vector : {&point.position, &point.normal}) {
      std::array<char, 3 * sizeof(float)> bytes{};
      std::memcpy(bytes.data(), vector->data(), bytes.size());
      hash = Fnv1a({bytes.data(), bytes.size()}, hash);
    }
  }
  return hash;
}

void AddModel(const ObjectModel& model, KeyText* key) {
  key->Line("model", model.id);
  key->Line("mesh", Format("%016jx", static_cast<uintmax_t>(model.mesh_hash)));
  key->Line("samples", Format("%016jx", static_cast<uintmax_t>(HashSamples(model))));
  key->Line("center", model.center.x(), model.center.y(), model.center.z());
  key->Line("diameter", model.diameter);
  const auto& [kind, elements, axis, flips] = model.symmetry;
  if (kind == SymmetryGroup::Kind::kContinuous) {
    key->Line("symmetry continuous", axis.x(), axis.y(), axis.z(), flips);
    return;
  }
  key->Line("symmetry finite", elements.size());
  for (const Eigen::Quaterniond& q : elements) key->Line("element", q.w(), q.x(), q.y(), q.z());
}

void AddViews(SequenceKind kind, const SimulatedViewParameters& parameters, KeyText* key) {
  const auto& [circle_views,
               circle_elevation_deg,
               circle_distance,
               random_views,
               lowest_elevation_deg,
               highest_elevation_deg,
               nearest_distance,
               farthest_distance,
               aim_jitter] = parameters;
  if (kind == SequenceKind::kCircle) {
    key->Line("circle", circle_views, circle_elevation_deg, circle_distance);
    return;
  }
  key->Line("random",
            random_views,
            lowest_elevation_deg,
            highest_elevation_deg,
            nearest_distance,
            farthest_distance,
            aim_jitter);
}

void AddCamera(const CameraModel& camera, KeyText* key) {
  const auto& [width, height, fx, fy, cx, cy] = camera;
  key->Line("camera", width, height, fx, fy, cx, cy);
}

void AddSensor(const SensorModelParameters& parameters, KeyText* key) {
  const auto& [seed,
               device_id,
               baseline,
               nearest,
               farthest,
               quantization,
               disparity_step,
               axial_noise,
               axial_sigma,
               grazing_sigma,
               correlation,
               lateral_noise,
               lateral_sigma,
               lateral_sigma_angle,
               edge_step,
               shadow,
               grazing_dropout,
               dropout_start,
               dropout_end,
               bias,
               bias_at_1m,
               bias_period] = parameters;
  static_cast<void>(seed);  // Both are every sequence's own.
  static_cast<void>(device_id);
  key->Line("sensor", baseline, nearest, farthest, quantization, disparity_step);
  key->Line("noise", axial_noise, axial_sigma, grazing_sigma, correlation);
  key->Line("edges", lateral_noise, lateral_sigma, lateral_sigma_angle, edge_step, shadow);
  key->Line("dropout", grazing_dropout, dropout_start, dropout_end);
  key->Line("bias", bias, bias_at_1m, bias_period);
}

void AddSegmentation(const SegmentationParameters& parameters, KeyText* key) {
  const auto& [support,
               plane,
               min_depth,
               max_depth,
               min_height,
               max_height,
               hull_margin,
               largest_gap,
               gap_px,
               min_points,
               concave_angle_deg,
               noise] = parameters;
  const auto& [iterations, inlier_sigmas, min_extent, min_share, max_planes] = plane;
  key->Line("segmentation",
            static_cast<int>(support),
            min_depth,
            max_depth,
            min_height,
            max_height,
            hull_margin,
            largest_gap,
            gap_px,
            min_points,
            concave_angle_deg,
            noise);
  key->Line("plane", iterations, inlier_sigmas, min_extent, min_share, max_planes);
}

void AddVoting(const PpfVotingParameters& parameters, KeyText* key) {
  const auto& [reference_share,
               min_references,
               max_references,
               turn_bins,
               spread,
               votes_per_reference,
               peaks_per_reference,
               cluster_distance,
               cluster_angle_deg,
               max_hypotheses] = parameters;
  key->Line("voting",
            reference_share,
            min_references,
            max_references,
            turn_bins,
            spread,
            votes_per_reference,
            peaks_per_reference,
            cluster_distance,
            cluster_angle_deg,
            max_hypotheses);
}

void AddVerification(const VerificationParameters& parameters, KeyText* key) {
  const auto& [inlier_sigmas,
               model_error,
               edge_px,
               coarse_step,
               min_score,
               min_visible,
               outlier_cost,
               missing_cost,
               foreign_gain,
               noise] = parameters;
  key->Line("verification",
            inlier_sigmas,
            model_error,
            edge_px,
            coarse_step,
            min_score,
            min_visible,
            outlier_cost,
            missing_cost,
            foreign_gain,
            noise);
}

void AddRefinement(const RefinementParameters& parameters, KeyText* key) {
  const auto& [coarse_iterations,
               coarse_reach,
               coarse_reach_end,
               fine_iterations,
               fine_points,
               fine_reach,
               final_iterations,
               final_points,
               tukey_sigmas,
               model_error,
               converged,
               correlated_px,
               bias_at_1m,
               bias_tilt,
               noise] = parameters;
  key->Line("refinement",
            coarse_iterations,
            coarse_reach,
            coarse_reach_end,
            fine_iterations,
            fine_points,
            fine_reach,
            final_iterations,
            final_points,
            tukey_sigmas,
            model_error,
            converged,
            correlated_px,
            bias_at_1m,
            bias_tilt,
            noise);
}

void AddEstimator(const PpfEstimatorParameters& parameters, KeyText* key) {
  const auto& [table, voting, estimation] = parameters;
  const auto& [segmentation,
               normals,
               verification,
               refinement,
               coarse_hypotheses,
               fine_hypotheses,
               max_scene_points,
               hypotheses_per_cluster] = estimation;
  const auto& [sample_distance, distance_step, angle_step_deg, max_points] = table;
  const auto& [radius, min_radius_px, max_radius_px, min_share, noise] = normals;
  key->Line("table", sample_distance, distance_step, angle_step_deg, max_points);
  AddSegmentation(segmentation, key);
  key->Line("normals", radius, min_radius_px, max_radius_px, min_share, noise);
  AddVoting(voting, key);
  AddVerification(verification, key);
  AddRefinement(refinement, key);
  key->Line(
      "hypotheses", coarse_hypotheses, fine_hypotheses, max_scene_points, hypotheses_per_cluster);
}

}  // namespace

std::string DetectionKey(const ObjectModel& model,
                         SequenceKind kind,
                         const SimulationParameters& parameters) {
  const auto& [seed, views, camera, sensor, estimator] = parameters;
  KeyText key;
  key.Line("version", kDetectionsVersion);
  AddModel(model, &key);
  key.Line("seed", seed);
  AddViews(kind, views, &key);
  AddCamera(camera, &key);
  AddSensor(sensor, &key);
  AddEstimator(estimator, &key);
  return key.text();
}

}  // namespace vantage
