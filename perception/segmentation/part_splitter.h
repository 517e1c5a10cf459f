#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/depth_rasterizer.h"
#include "perception/segmentation/segmentation_parameters.h"

namespace vantage {

/// Divides a cluster where its surface is concave or has a step, as objects that touch do: Stein,
/// Schoeler, Papon, Woergoetter, "Object partitioning using local convexity", CVPR 2014. In place
/// of supervoxels there are patches of 4 x 4 px, with planes fitted to the inverse depth of 3 x 3
/// of them; in place of their singular connections, a way between two parts must be two patches
/// wide. Owns its buffers: allocates nothing once warm.
class PartSplitter {
 public:
  explicit PartSplitter(const SegmentationParameters& parameters) : parameters_(parameters) {}

  /// @param pixels indices, ascending, that `window` holds; all have depth.
  /// @return number of parts, numbered from 0 in no order; 1 when there is nothing to divide
  int Split(const DepthImage& depth,
            const CameraModel& camera,
            std::span<const uint32_t> pixels,
            const PixelWindow& window);

  /// Part of each of the pixels. Valid until the next call.
  [[nodiscard]] std::span<const int32_t> parts() const { return parts_; }

 private:
  // n, u, v, uu, uv, vv, rho, u rho, v rho: sums over pixels.
  using Moments = std::array<double, 9>;
  struct Fit {
    bool is_valid = false;
    float a = 0.0F, b = 0.0F, c = 0.0F;  // rho = a u + b v + c, from the window's corner.
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    Eigen::Vector3f center = Eigen::Vector3f::Zero();  // m, on the plane, behind the patch's
  };
  struct Patch {
    int32_t count = 0;  // px
    int32_t part = -1;
    uint32_t source = 0;  // Patch whose plane stands for it.
    bool cut_right = false, cut_down = false;
    bool link_right = false, link_down = false;  // With its neighbor in the core of a part.
  };

  void AddPixels(const DepthImage& depth, std::span<const uint32_t> pixels);
  void SumNeighbors();
  void FitPlanes(const CameraModel& camera);
  [[nodiscard]] bool IsCut(const Fit& before, const Fit& after, float u, float v) const;
  void CutEdges();
  void LinkCores();
  int FindCores();
  void Grow();
  void AssignPixels(const DepthImage& depth, std::span<const uint32_t> pixels);
  [[nodiscard]] int32_t NearestPlane(uint32_t patch, float u, float v, float rho) const;

  SegmentationParameters parameters_;
  PixelWindow window_;
  CameraModel camera_;
  int columns_ = 0;  // Of patches, with one more on each side.
  int rows_ = 0;
  std::vector<Moments> moments_, sums_;
  std::vector<Fit> fits_;
  std::vector<Patch> patches_;
  std::vector<uint32_t> queue_;
  std::vector<int32_t> parts_;
};

}  // namespace vantage
