#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "common/depth_image.h"
#include "common/result.h"
#include "vantage/images_t.hpp"

namespace vantage {

/// A depth image as it comes over the bus.
struct DepthFrame {
  int64_t utime = 0;   ///< us since the epoch, of the exposure
  int64_t seq = -1;    ///< counts images of this stream; -1: the sender does not say
  std::string serial;  ///< of the device; empty: the sender does not say
  DepthImage image;    ///< m
};

inline constexpr int kMaxImageSide = 4096;  ///< px

/// The first image of type DEPTH_MM, DEPTH_MM_ZIPPED or DEPTH_MM_VDC.
/// Errors: as CheckUtime; none there; a side outside 1..kMaxImageSide; a row stride or number of
/// bytes that does not belong to the size; a compressed stream that does not hold exactly the
/// image.
Result<DepthFrame> DepthFrameFromMessage(const images_t& message);

enum class DepthCompression {
  kNone,  ///< DEPTH_MM
  kZlib,  ///< DEPTH_MM_ZIPPED, level 1
  kVdc,   ///< DEPTH_MM_VDC, the depth codec of common/depth_codec
};

/// @param millimetres width * height values, 0 where there is no measurement.
///   Sides above kMaxDepthSide are not for kVdc.
images_t DepthToMessage(int width,
                        int height,
                        std::span<const uint16_t> millimetres,
                        int64_t utime,
                        int64_t seq,
                        const std::string& serial,
                        DepthCompression compression);

/// Bytes of a pixel of GRAY, RGB or BGR; 0 for other pixel formats.
size_t BytesPerPixel(int32_t pixelformat);

/// Adds the metadata "seq" and "serial" to an image.
void AppendIdentity(int64_t seq, const std::string& serial, image_t* image);

/// Adds another image that was taken together with those of `message`. Fills image.size and
/// image.nmetadata from the vectors.
void AppendImage(int16_t type, image_t image, images_t* message);

/// Reads the metadata "seq" of an image; -1 when it is absent or not 8 bytes.
int64_t ImageSeq(const image_t& image);

}  // namespace vantage
