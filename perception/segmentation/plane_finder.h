#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/rng.h"
#include "perception/depth_noise.h"
#include "perception/segmentation/plane_patch.h"
#include "perception/segmentation/support_plane.h"

namespace vantage {

/// Finds the large planes of a depth image on a coarse grid of pixels. A plane is affine in inverse
/// depth, rho = a u + b v + c, where the noise of a pixel does not depend on the plane. Owns its
/// buffers: allocates nothing once warm.
class PlaneFinder {
 public:
  PlaneFinder(const SupportPlaneParameters& parameters, const DepthNoise& noise)
      : parameters_(parameters), noise_(noise) {}

  /// RANSAC, then least squares on the plane's points, then the same without them. Past the first,
  /// a plane is one connected patch that hardly any line of sight goes through (level parts of
  /// separate objects are none), of `min_extent` in its narrowest direction. The plane on which
  /// most stands carries objects, the first when in doubt; so do those that are parallel to it (a
  /// shelf's boards); others are walls. Deterministic for a state of `rng`.
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
    std::vector<uint32_t> cell;    // Of the grid.
    [[nodiscard]] size_t size() const { return u.size(); }
    void Clear();
    void Add(const Points& from, size_t i);
  };

  void Collect(const DepthImage& depth, double min_depth, double max_depth);
  bool FindOne(Rng& rng, Eigen::Vector3d* affine);
  bool BestOfRandom(Rng& rng, Eigen::Vector3d* affine);
  static bool Fit(const Points& points, std::span<const uint8_t> is_used, Eigen::Vector3d* affine);
  void MarkInliers(const Eigen::Vector3d& affine);
  // Make a plane at the end of spare_; false when it isn't a large one.
  bool TakeFirst(const CameraModel& camera, const Eigen::Vector3d& affine);
  bool TakeLater(const CameraModel& camera, Eigen::Vector3d affine);
  void FindPatch(const Eigen::Vector3d& affine);
  void MakePlane(const CameraModel& camera, const Eigen::Vector3d& affine, SupportPlane* plane);
  void RemoveInliers(bool is_taken);
  void ChooseSupport(const CameraModel& camera, std::span<SupportPlane> planes) const;
  [[nodiscard]] size_t CountStanding(const CameraModel& camera, const SupportPlane& plane) const;

  SupportPlaneParameters parameters_;
  DepthNoise noise_;
  // The grid, row by row: every point that is measured.
  Points cells_;
  int grid_width_ = 0;
  std::vector<uint8_t> is_free_;    // In range, and on no plane so far.
  std::vector<PlaneSight> sights_;  // Of a plane.
  PlanePatch patch_;
  std::vector<uint8_t> members_;  // Cells of a plane.

  Points points_;        // In range, and on no plane that was tried.
  Points few_;           // Of points_, on which hypotheses are counted.
  double fewest_ = 0.0;  // Points of the first plane.
  std::vector<uint8_t> is_inlier_;
  size_t num_inliers_ = 0;
  std::vector<Eigen::Vector2d> hull_;
  std::vector<SupportPlane> spare_;  // With buffers for hulls.
};

}  // namespace vantage
