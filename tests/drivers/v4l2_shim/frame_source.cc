#include "tests/drivers/v4l2_shim/frame_source.h"

#include <linux/videodev2.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>

// Needs <cstdio> before it.
#include <jpeglib.h>

#include "tests/drivers/v4l2_shim/test_scene.h"

namespace vantage::v4l2_shim {
namespace {

constexpr uint32_t kLargestSide = 4096;
constexpr int kJpegQuality = 95;

using Bytes = std::vector<uint8_t>;

void AppendLittleEndian(uint16_t value, Bytes* bytes) {
  bytes->push_back(static_cast<uint8_t>(value));
  bytes->push_back(static_cast<uint8_t>(value >> 8));
}

// Two bytes a pixel, chroma of every other one.
Bytes DrawPackedYuv(int width, int height, int phase, bool luma_first) {
  Bytes bytes;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const YCbCr color = SharpColor(x, y, phase);
      const uint8_t chroma = x % 2 == 0 ? color.cb : color.cr;
      bytes.push_back(luma_first ? color.y : chroma);
      bytes.push_back(luma_first ? chroma : color.y);
    }
  }
  return bytes;
}

Bytes DrawGray(int width, int height, int phase) {
  Bytes bytes;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) bytes.push_back(SharpColor(x, y, phase).y);
  }
  return bytes;
}

// Green and red in the first row, blue and green in the second.
Bytes DrawBayer(int width, int height, int phase) {
  Bytes bytes;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const size_t channel = x % 2 == y % 2 ? 1 : (y % 2 == 0 ? 0 : 2);
      bytes.push_back(SmoothColor(x, y, phase, width, height)[channel]);
    }
  }
  return bytes;
}

Bytes DrawDepth(int width, int height, int phase) {
  Bytes bytes;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) AppendLittleEndian(DepthValue(x, y, phase), &bytes);
  }
  return bytes;
}

// Ten bits a pixel without gaps, the highest first.
Bytes DrawDisparity(int width, int height, int phase) {
  Bytes bytes;
  uint32_t bits = 0;
  int num_bits = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      bits = bits << 10 | DisparityValue(x, y, phase);
      for (num_bits += 10; num_bits >= 8; num_bits -= 8) {
        bytes.push_back(static_cast<uint8_t>(bits >> (num_bits - 8)));
      }
    }
  }
  return bytes;
}

// The segments DHT taken out, which baseline decoders fill with the standard's tables.
Bytes WithoutHuffmanTables(const Bytes& jpeg) {
  constexpr uint8_t kHuffmanTable = 0xC4;
  constexpr uint8_t kStartOfScan = 0xDA;
  Bytes stripped(jpeg.begin(), jpeg.begin() + 2);
  size_t i = 2;
  while (jpeg.at(i + 1) != kStartOfScan) {
    const size_t length = 2 + (size_t{jpeg.at(i + 2)} << 8 | jpeg.at(i + 3));
    if (jpeg[i + 1] != kHuffmanTable) {
      stripped.insert(stripped.end(), &jpeg[i], &jpeg[i] + length);
    }
    i += length;
  }
  stripped.insert(stripped.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(i), jpeg.end());
  return stripped;
}

Bytes DrawJpeg(int width, int height, int phase) {
  jpeg_compress_struct compress{};
  jpeg_error_mgr errors{};
  compress.err = jpeg_std_error(&errors);
  jpeg_create_compress(&compress);
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&compress, &buffer, &size);
  compress.image_width = static_cast<JDIMENSION>(width);
  compress.image_height = static_cast<JDIMENSION>(height);
  compress.input_components = 3;
  compress.in_color_space = JCS_RGB;
  jpeg_set_defaults(&compress);
  jpeg_set_quality(&compress, kJpegQuality, TRUE);
  jpeg_start_compress(&compress, TRUE);
  Bytes row;
  for (int y = 0; y < height; ++y) {
    row.clear();
    for (int x = 0; x < width; ++x) {
      for (const uint8_t value : SmoothColor(x, y, phase, width, height)) row.push_back(value);
    }
    JSAMPROW rows[] = {row.data()};
    jpeg_write_scanlines(&compress, rows, 1);
  }
  jpeg_finish_compress(&compress);
  jpeg_destroy_compress(&compress);
  Bytes jpeg(buffer, buffer + size);
  std::free(buffer);
  return jpeg;
}

Bytes Draw(const Device& device, uint32_t fourcc, int width, int height, int phase) {
  switch (fourcc) {
    case V4L2_PIX_FMT_YUYV:
      return DrawPackedYuv(width, height, phase, true);
    case V4L2_PIX_FMT_UYVY:
      return DrawPackedYuv(width, height, phase, false);
    case V4L2_PIX_FMT_GREY:
      return DrawGray(width, height, phase);
    case V4L2_PIX_FMT_SGRBG8:
      return DrawBayer(width, height, phase);
    case V4L2_PIX_FMT_Y16:
    case V4L2_PIX_FMT_Z16:
      return DrawDepth(width, height, phase);
    case V4L2_PIX_FMT_Y10BPACK:
      return DrawDisparity(width, height, phase);
    case V4L2_PIX_FMT_MJPEG: {
      const Bytes jpeg = DrawJpeg(width, height, phase);
      return device.jpeg_tables ? jpeg : WithoutHuffmanTables(jpeg);
    }
    default:
      return {};
  }
}

uint32_t RowBytes(uint32_t fourcc, uint32_t width) {
  switch (fourcc) {
    case V4L2_PIX_FMT_GREY:
    case V4L2_PIX_FMT_SGRBG8:
      return width;
    case V4L2_PIX_FMT_Y10BPACK:
      return static_cast<uint32_t>(uint64_t{width} * 10 / 8);
    default:
      return 2 * width;
  }
}

Bytes WithPadding(const Bytes& frame, size_t row_bytes, size_t padding) {
  constexpr uint8_t kPadding = 0xA5;
  Bytes padded;
  for (size_t i = 0; i < frame.size(); i += row_bytes) {
    padded.insert(padded.end(), &frame[i], &frame[i] + row_bytes);
    padded.insert(padded.end(), padding, kPadding);
  }
  return padded;
}

std::vector<Bytes> ReadFrames(const std::string& file, size_t frame_bytes) {
  std::ifstream stream(file, std::ios::binary);
  const Bytes all((std::istreambuf_iterator<char>(stream)), {});
  std::vector<Bytes> frames;
  for (size_t i = 0; frame_bytes > 0 && i + frame_bytes <= all.size(); i += frame_bytes) {
    frames.emplace_back(&all[i], &all[i] + frame_bytes);
  }
  if (frames.empty()) throw std::runtime_error("no whole frame in " + file);
  return frames;
}

}  // namespace

uint32_t BytesPerLine(const Device& device, uint32_t fourcc, uint32_t width) {
  if (fourcc == V4L2_PIX_FMT_MJPEG) return 0;
  return RowBytes(fourcc, width) + device.padding_bytes;
}

uint32_t SizeImage(const Device& device, uint32_t fourcc, uint32_t width, uint32_t height) {
  if (fourcc == V4L2_PIX_FMT_MJPEG) return 2 * width * height + 4096;
  return BytesPerLine(device, fourcc, width) * height;
}

std::vector<Bytes> DrawFrames(const Device& device,
                              uint32_t fourcc,
                              uint32_t width,
                              uint32_t height) {
  if (!device.frames_file.empty()) {
    return ReadFrames(device.frames_file, SizeImage(device, fourcc, width, height));
  }
  std::vector<Bytes> frames;
  if (width == 0 || height == 0 || width > kLargestSide || height > kLargestSide) return frames;
  for (int phase = 0; phase < kNumPhases; ++phase) {
    Bytes frame = Draw(device, fourcc, static_cast<int>(width), static_cast<int>(height), phase);
    if (frame.empty()) return frames;
    if (fourcc != V4L2_PIX_FMT_MJPEG && device.padding_bytes > 0) {
      frame = WithPadding(frame, RowBytes(fourcc, width), device.padding_bytes);
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace vantage::v4l2_shim
