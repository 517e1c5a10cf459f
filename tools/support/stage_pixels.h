#pragma once

#include <cstdint>
#include <vector>

#include "perception/verification/verification.h"

namespace vantage {

/// What a pixel tells of a hypothesis: the counts of Verification, pixel by pixel.
enum class PixelRole : uint8_t {
  kNone,  ///< Neither of the model nor of the cluster.
  kInlier,
  kOccluded,
  kSeenThrough,
  kInFront,
  kMissing,
  kEdge,
  kUnexplained,
};

/// Roles of all pixels of the image, row by row, at full resolution.
std::vector<PixelRole> FindPixelRoles(const ModelShape& model,
                                      const Pose& T_camera_object,
                                      const SegmentedImage& image,
                                      size_t cluster,
                                      const VerificationParameters& parameters);

}  // namespace vantage
