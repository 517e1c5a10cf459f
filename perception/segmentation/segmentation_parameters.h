#pragma once

#include "common/result.h"
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
  int min_points = 200;        ///< px; smaller clusters are dropped, smaller parts are not made
  double concave_angle_deg = 40.0;  ///< that a surface bends inwards between parts; 180: none
  DepthNoise noise;
  Result<void> Validate() const;
};

}  // namespace vantage
