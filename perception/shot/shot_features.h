#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/triangle_mesh.h"

namespace vantage {

/// Values of a SHOT descriptor: 32 parts of a ball, 11 bins of the angle to the normal.
inline constexpr size_t kShotSize = 352;

/// A keypoint, and the unit vector that describes its neighborhood.
struct ShotFeature {
  SurfacePoint point;
  std::array<float, kShotSize> descriptor;
};

/// SHOT descriptors (Tombari et al. 2010) by PCL, in the local frames of PCL, but z on the side of
/// the keypoint's normal: PCL takes the side of most points, which is noise on flat surfaces.
/// PCL allocates in every call (its search, its frames); nothing else of this class does once warm.
class ShotFeatures {
 public:
  ShotFeatures();
  ~ShotFeatures();
  ShotFeatures(ShotFeatures&&) noexcept;
  ShotFeatures& operator=(ShotFeatures&&) noexcept;

  /// Features of `points[i]` for i in `keypoints`, in their order, without those that have fewer
  /// than 5 neighbors within `radius` m. Valid until the next call.
  /// @param points finite.
  std::span<const ShotFeature> Compute(std::span<const SurfacePoint> points,
                                       std::span<const uint32_t> keypoints,
                                       double radius);

 private:
  struct Clouds;
  std::unique_ptr<Clouds> clouds_;
  std::vector<ShotFeature> features_;
};

}  // namespace vantage
