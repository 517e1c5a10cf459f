#pragma once

#include "common/depth_image.h"
#include "tools/viewer/scene_cloud.h"
#include "vantage/images_t.hpp"

namespace vantage {

/// The colors of the first color or gray image (LEFT) that came with a depth image, RGB, BGR, gray
/// or JPEG: that of the depth pixel's place, scaled where the sizes differ. Empty when there is
/// none or it is not what it claims.
PixelColor ColorOf(const images_t& images, const DepthImage& depth);

}  // namespace vantage
