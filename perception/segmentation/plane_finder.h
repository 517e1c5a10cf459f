#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/rng.h"
#include "perception/depth_noise.h"
#include "perception/segmentation/support_plane.h"

namespace vantage {

/// Finds the large planes of a depth image on a coarse grid of pixels. A plane is affine in inverse
/// depth, rho = a u + b v + c, where the noise of a pixel does not depend on the plane. Owns its
/// buffers: allocates nothing once warm.
class PlaneFinder {
 public:
  PlaneFinder(const SupportPlaneParameters& parameters, const DepthNoise& noise)
      : parameters_(parameters), noise_(noise) {}

  /// RANSAC, then least squares on the plane's points, then the same without them. The first plane
  /// carries objects, so do those that are parallel to it (a shelf's boards); others are walls.
  /// Past the first, a plane must be of `min_extent` in its narrowest direction. Deterministic for
  /// a state of `rng`.
  /// @param min_depth, max_depth m; other pixels are left out.
  /// @param planes whose hulls are reused.
  void Find(const DepthImage& depth,
            const CameraModel& camera,
            double min_depth,
            double max_depth,
            Rng& rng,
            std::vector<SupportPlane>* planes);

 private:
  // Points in columns, so that they are read in lanes.
  struct Points {
    std::vector<float> u, v, rho;  // px, px, 1/m
    std::vector<float> tolerance;  // 1/m
    [[nodiscard]] size_t size() const { return u.size(); }
    void Clear();
    void Add(float at_u, float at_v, float at_rho, float at_tolerance);
  };

  void Collect(const DepthImage& depth, double min_depth, double max_depth);
  bool FindOne(Rng& rng, Eigen::Vector3d* affine);
  bool BestOfRandom(Rng& rng, Eigen::Vector3d* affine);
  bool FitToInliers(Eigen::Vector3d* affine) const;
  void MarkInliers(const Eigen::Vector3d& affine);
  void MakePlane(const CameraModel& camera, const Eigen::Vector3d& affine, SupportPlane* plane);
  void RemoveInliers();

  SupportPlaneParameters parameters_;
  DepthNoise noise_;
  Points points_;
  Points few_;  // Of points_, on which hypotheses are counted.
  std::vector<uint8_t> is_inlier_;
  size_t num_inliers_ = 0;
  std::vector<Eigen::Vector2d> hull_;
  std::vector<SupportPlane> spare_;  // With buffers for hulls.
};

}  // namespace vantage
