#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "perception/segmentation/segmentation_parameters.h"
#include "perception/segmentation/support_plane.h"

namespace vantage {

/// The pixels that may belong to objects: those above a plane that carries, over its hull, and on
/// no plane; without planes all whose depth is in range. Owns its buffers.
class Foreground {
 public:
  explicit Foreground(const SegmentationParameters& parameters) : parameters_(parameters) {}

  /// 1 where a pixel may belong to an object, else 0, row by row. Valid until the next call.
  std::span<const uint8_t> Find(const DepthImage& depth,
                                const CameraModel& camera,
                                std::span<const SupportPlane> planes);

 private:
  // Half space in which z * (along_u u + along_v v + constant) >= bound.
  struct HalfSpace {
    double along_u, along_v, constant, bound;
  };
  // A plane as rows of pixels see it; its height is z * (along_u u + along_v v + constant) - bound.
  struct Body {
    HalfSpace height;
    size_t first_side, num_sides;  // Of its hull, widened by the margin.
    bool carries;
  };

  void Prepare(const CameraModel& camera, std::span<const SupportPlane> planes);
  void FindRow(const float* depth, int v, uint8_t* mask);
  void KeepOverHull(const Body& body, const float* depth, int v, uint8_t* mask) const;

  SegmentationParameters parameters_;
  std::vector<Body> bodies_;
  std::vector<HalfSpace> sides_;
  std::vector<float> columns_;  // 0, 1, 2 ...: of pixels, padded to whole lanes.
  std::vector<uint8_t> row_;
  std::vector<uint8_t> mask_;
};

}  // namespace vantage
