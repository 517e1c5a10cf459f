#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/depth_rasterizer.h"
#include "common/result.h"
#include "common/rng.h"
#include "perception/depth_noise.h"
#include "perception/segmentation/support_plane.h"

namespace vantage {

struct SegmentationParameters {
  enum class Support {
    kAuto,  ///< Removes a large plane and what lies below it, if there is one.
    kNone,  ///< All valid points are of objects: images that are segmented already.
  };
  Support support = Support::kAuto;
  SupportPlaneParameters plane;
  double min_depth = 0.2;      ///< m; nearer points are noise of the sensor
  double max_depth = 3.0;      ///< m; farther points are background
  double min_height = 0.005;   ///< m above the plane; at least 3 sigmas of noise are kept clear
  double max_height = 0.5;     ///< m above the plane
  double hull_margin = 0.02;   ///< m outside the plane's hull where objects may still be
  double largest_gap = 0.012;  ///< m between neighbors of one cluster, beyond their spacing
  int gap_px = 2;              ///< px that missing data may bridge
  int min_points = 200;        ///< px; smaller clusters are dropped
  DepthNoise noise;
  Result<void> Validate() const;
};

/// Connected pixels that may be one object.
struct Cluster {
  std::vector<uint32_t> pixels;  ///< Indices into the image, ascending.
  PixelWindow window;            ///< Smallest that holds them.
  bool touches_border = false;   ///< The object may reach out of the image.
};

struct Segmentation {
  static constexpr int32_t kNoCluster = -1;

  std::optional<SupportPlane> plane;
  std::vector<Cluster> clusters;  ///< Largest first, equal ones by their first pixel.
  std::vector<int32_t> labels;    ///< Per pixel: index of its cluster, or kNoCluster.
};

/// Clusters of points above the support plane, or of all points when there is none.
/// @param depth of the camera's width and height.
Segmentation Segment(const DepthImage& depth,
                     const CameraModel& camera,
                     const SegmentationParameters& parameters,
                     Rng& rng);

}  // namespace vantage
