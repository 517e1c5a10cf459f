#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "common/camera_model.h"
#include "common/detection.h"
#include "common/result.h"
#include "fusion/object_tracker.h"
#include "nodes/depth_memory.h"
#include "nodes/object_refinement_config.h"
#include "perception/model/object_model.h"
#include "perception/refinement/multi_view_refiner.h"
#include "perception/verification/drawable_mesh.h"
#include "vantage/images_t.hpp"

namespace vantage {

/// What the refinement needs to know of a model.
struct RefinedModel {
  explicit RefinedModel(const ObjectModel& model);

  DrawableMesh mesh;
  Eigen::Vector3d center;  ///< m
  double diameter;         ///< m
  double radius;           ///< m, of the ball about the center that holds it
  SymmetryGroup symmetry;
};

/// Refines fused poses on the depth of all images that their detections come from, once an object
/// is confirmed and its mode is settled.
class ObjectRefinement {
 public:
  using Models = std::map<std::string, std::shared_ptr<const RefinedModel>>;

  /// @param config with a camera, valid.
  ObjectRefinement(const ObjectRefinementConfig& config, Models models);

  void OnCamera(const CameraModel& camera);
  void OnImages(const images_t& message) { memory_.Add(message); }
  /// After the tracker took up `set`: keeps its image where an object's estimate rests on it, and
  /// refines all settled objects anew. Errors: the image is damaged or does not go with the camera;
  /// what there is already is refined all the same.
  Result<void> OnSet(const DetectionSet& set, std::span<const ObjectEstimate> objects);

  /// Of the last call, by instance id; of those alone that are settled.
  [[nodiscard]] const std::map<int, MultiViewRefined>& refined() const { return refined_; }

 private:
  [[nodiscard]] bool IsSettled(const ObjectEstimate& object) const;
  void RefineSettled(std::span<const ObjectEstimate> objects);

  ObjectRefinementConfig config_;
  Models models_;
  std::optional<CameraModel> camera_;
  DepthMemory memory_;
  MultiViewRefiner refiner_;
  std::map<int, MultiViewRefined> refined_;
};

}  // namespace vantage
