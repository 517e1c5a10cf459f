#pragma once

#include <Eigen/Core>

#include "tools/support/color.h"
#include "tools/support/png_image.h"

namespace vantage {

/// Pixel (0, 0) is a pixel's centre, as in the camera model. What lies outside is left out.

RgbImage FilledImage(int width, int height, Rgb color);
Rgb PixelAt(const RgbImage& image, int u, int v);
void SetPixel(RgbImage& image, int u, int v, Rgb color);
/// Covers `coverage` in [0, 1] of the pixel.
void BlendPixel(RgbImage& image, int u, int v, Rgb color, double coverage);
/// A smooth-edged line with round ends, `width` px wide.
void DrawLine(RgbImage& image,
              const Eigen::Vector2d& from,
              const Eigen::Vector2d& to,
              double width,
              Rgb color);
/// A smooth-edged disk of `radius` px.
void DrawDisk(RgbImage& image, const Eigen::Vector2d& center, double radius, Rgb color);
/// The mean of each block of factor x factor pixels; what is left over at right and bottom goes.
RgbImage Downsample(const RgbImage& image, int factor);

}  // namespace vantage
