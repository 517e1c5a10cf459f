#pragma once

#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/depth_rasterizer.h"
#include "common/so3.h"
#include "common/triangle_mesh.h"
#include "tools/support/color.h"
#include "tools/support/png_image.h"

namespace vantage {

/// A model in an estimated pose, to draw on a depth image; `mesh` outlives the drawing.
struct OutlinedModel {
  const TriangleMesh* mesh = nullptr;
  Pose T_camera_mesh = Pose::Identity();
  Rgb color;
  double strength = 1.0;  ///< [0, 1], how much of what is below the outline covers
};

/// A depth image in false color, cut to where the models are, with their outlines on it.
struct DepthView {
  RgbImage image;
  std::vector<PixelWindow> windows;  ///< Of each model in `image`; empty where it is not in view.
  double near = 0.0;                 ///< m, drawn in the lightest color
  double far = 0.0;                  ///< m, drawn in the darkest color
};

/// Draws silhouettes strongly, and creases and steps inside them lightly.
/// @param width, height of the picture, px.
/// Without a model in view the whole depth image is shown, as large as it fits.
DepthView DrawDepthView(const DepthImage& depth,
                        const CameraModel& camera,
                        const std::vector<OutlinedModel>& models,
                        int width,
                        int height);

/// The same, cut to a window of the depth image.
DepthView DrawDepthView(const DepthImage& depth,
                        const CameraModel& camera,
                        const PixelWindow& window,
                        const std::vector<OutlinedModel>& models,
                        int width,
                        int height);

/// The camera that sees what `window` of `camera`'s image shows, as a picture of `width` x `height`
/// px: the window grown to that shape.
CameraModel CutCamera(const CameraModel& camera, const PixelWindow& window, int width, int height);

}  // namespace vantage
