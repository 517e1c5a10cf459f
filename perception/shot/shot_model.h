#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "perception/model/object_model.h"
#include "perception/shot/correspondence_ransac.h"
#include "perception/shot/inner_products.h"
#include "perception/shot/shot_features.h"
#include "perception/shot/shot_parameters.h"

namespace vantage {

/// A model's keypoints p_k,m and their descriptors, as they look from all sides: near the outline
/// a camera sees half of a neighborhood, so every keypoint has descriptors of several views.
class ShotModel {
 public:
  /// Draws the model from `training_views` sides as a depth camera would see it, and describes the
  /// keypoints of each. Errors: parameters, no side shows enough of the surface.
  static Result<ShotModel> Train(const ObjectModel& object, const ShotParameters& parameters);

  /// To each of the target's features those `k` model keypoints whose descriptors are nearest, no
  /// pair of keypoints twice (paper section 3.2, step 3).
  void Match(std::span<const ShotFeature> target, std::vector<Correspondence>* correspondences);

  [[nodiscard]] double diameter() const { return diameter_; }
  [[nodiscard]] size_t num_descriptors() const { return points_.size(); }

 private:
  ShotModel() = default;
  struct Candidate {
    float likeness;
    uint32_t descriptor;
  };
  void Project(std::span<const ShotFeature> features);
  void SetDescriptors(std::span<const ShotFeature> features);
  float Insert(float likeness, uint32_t descriptor);
  [[nodiscard]] float Bar() const;

  double diameter_ = 0.0;  // m
  int k_ = 0;
  int size_ = 0;                      // Of a descriptor.
  std::vector<SurfacePoint> points_;  // Of the descriptors.
  std::vector<uint32_t> keypoints_;   // p_k,m, of the descriptors.
  InnerProducts basis_;               // Principal components.
  InnerProducts descriptors_;         // In the basis.
  std::vector<float> half_squares_;   // Of the descriptors' lengths.
  std::vector<float> raw_;            // Reused from here on.
  std::vector<float> projected_;
  std::vector<float> reduced_;
  std::vector<float> products_;
  std::vector<Candidate> best_;
};

/// Of `points` in their order the indices of those at least `distance` m from all that were taken
/// before.
void SelectKeypoints(std::span<const SurfacePoint> points,
                     double distance,
                     std::vector<uint32_t>* keypoints);

}  // namespace vantage
