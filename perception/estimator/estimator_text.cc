#include "perception/estimator/estimator_text.h"

// Parameters are taken apart by structured bindings: a new one does not compile until it is listed.

namespace vantage {
namespace {

template <class... Values>
void LineWithNoise(ParameterText* text,
                   const char* name,
                   const DepthNoise& noise,
                   const Values&... values) {
  const auto& [axial_base, axial_quadratic, axial_offset, lateral_px] = noise;
  text->Line(name, values..., axial_base, axial_quadratic, axial_offset, lateral_px);
}

void AddSegmentation(const SegmentationParameters& parameters, ParameterText* text) {
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
  const auto& [iterations, inlier_sigmas, min_extent, min_share, max_planes, grid_px] = plane;
  LineWithNoise(text,
                "segmentation",
                noise,
                static_cast<int>(support),
                min_depth,
                max_depth,
                min_height,
                max_height,
                hull_margin,
                largest_gap,
                gap_px,
                min_points,
                concave_angle_deg);
  text->Line("plane", iterations, inlier_sigmas, min_extent, min_share, max_planes);
  if (grid_px != 0) text->Line("grid", grid_px);
}

void AddNormals(const NormalParameters& parameters, ParameterText* text) {
  const auto& [radius, min_radius_px, max_radius_px, min_share, noise] = parameters;
  LineWithNoise(text, "normals", noise, radius, min_radius_px, max_radius_px, min_share);
}

void AddVoting(const PpfVotingParameters& parameters, ParameterText* text) {
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
  text->Line("voting",
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

void AddShot(const ShotParameters& parameters, ParameterText* text) {
  const auto& [spacing,
               keypoint_spacing,
               descriptor_radius,
               training_views,
               descriptor_size,
               k,
               t_r,
               t_d,
               t_alpha_deg,
               inlier_distance,
               probability,
               max_iterations,
               max_hypotheses] = parameters;
  text->Line(
      "descriptors", spacing, keypoint_spacing, descriptor_radius, training_views, descriptor_size);
  text->Line("consensus",
             k,
             t_r,
             t_d,
             t_alpha_deg,
             inlier_distance,
             probability,
             max_iterations,
             max_hypotheses);
}

void AddVerification(const VerificationParameters& parameters, ParameterText* text) {
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
  LineWithNoise(text,
                "verification",
                noise,
                inlier_sigmas,
                model_error,
                edge_px,
                coarse_step,
                min_score,
                min_visible,
                outlier_cost,
                missing_cost,
                foreign_gain);
}

void AddRefinement(const RefinementParameters& parameters, ParameterText* text) {
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
  LineWithNoise(text,
                "refinement",
                noise,
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
                bias_tilt);
}

// `add_proposer` adds what proposes poses.
template <class AddProposer>
void AddEstimation(const PoseEstimatorParameters& parameters,
                   const AddProposer& add_proposer,
                   ParameterText* text) {
  const auto& [segmentation,
               normals,
               verification,
               refinement,
               coarse_hypotheses,
               fine_hypotheses,
               max_scene_points,
               hypotheses_per_cluster] = parameters;
  AddSegmentation(segmentation, text);
  AddNormals(normals, text);
  add_proposer();
  AddVerification(verification, text);
  AddRefinement(refinement, text);
  text->Line(
      "hypotheses", coarse_hypotheses, fine_hypotheses, max_scene_points, hypotheses_per_cluster);
}

template <class Parameters>
std::string VersionAndParameters(const Parameters& parameters) {
  ParameterText text;
  text.Line("version", kDetectionsVersion);
  AddEstimator(parameters, &text);
  return text.text();
}

}  // namespace

void AddEstimator(const PpfEstimatorParameters& parameters, ParameterText* text) {
  const auto& [table, voting, estimation] = parameters;
  const auto& [sample_distance, distance_step, angle_step_deg, max_points] = table;
  text->Line("table", sample_distance, distance_step, angle_step_deg, max_points);
  AddEstimation(
      estimation, [&] { AddVoting(parameters.voting, text); }, text);
}

void AddEstimator(const ShotEstimatorParameters& parameters, ParameterText* text) {
  const auto& [shot, estimation] = parameters;
  AddEstimation(
      estimation, [&] { AddShot(parameters.shot, text); }, text);
}

std::string EstimatorText(const PpfEstimatorParameters& parameters) {
  return VersionAndParameters(parameters);
}

std::string EstimatorText(const ShotEstimatorParameters& parameters) {
  return VersionAndParameters(parameters);
}

}  // namespace vantage
