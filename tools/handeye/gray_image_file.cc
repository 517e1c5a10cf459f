#include "tools/handeye/gray_image_file.h"

#include <algorithm>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "common/format.h"
#include "perception/model/file_bytes.h"

namespace vantage {
namespace {

constexpr size_t kLargestFile = 256U << 20U;  // bytes
constexpr int kLargestSide = 16384;           // px
// Pixels a byte may hold: deflate expands by no more than 1032, and a byte has 8 pixels; JPEG's
// blocks of 64 pixels take at least a bit or two for each component.
constexpr size_t kMostPixelsPerByte = 8256;

struct ImageSize {
  int width = 0;
  int height = 0;
};

uint32_t BigEndian(std::string_view bytes, size_t at, size_t size) {
  uint32_t value = 0;
  for (size_t i = 0; i < size; ++i) value = value << 8U | static_cast<uint8_t>(bytes[at + i]);
  return value;
}

// Of the header chunk, which comes first.
std::optional<ImageSize> PngSize(std::string_view bytes) {
  if (bytes.size() < 24 || !bytes.starts_with("\x89PNG\r\n\x1a\n") ||
      bytes.substr(12, 4) != "IHDR" || BigEndian(bytes, 16, 4) > kLargestSide ||
      BigEndian(bytes, 20, 4) > kLargestSide) {
    return std::nullopt;
  }
  return ImageSize{static_cast<int>(BigEndian(bytes, 16, 4)),
                   static_cast<int>(BigEndian(bytes, 20, 4))};
}

// Of the first frame header (ITU-T T.81, B.2.2).
std::optional<ImageSize> JpegSize(std::string_view bytes) {
  if (!bytes.starts_with("\xff\xd8")) return std::nullopt;
  size_t at = 2;
  while (at + 9 <= bytes.size() && bytes[at] == '\xff') {
    const auto marker = static_cast<uint8_t>(bytes[at + 1]);
    const bool is_frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (is_frame) {
      return ImageSize{static_cast<int>(BigEndian(bytes, at + 7, 2)),
                       static_cast<int>(BigEndian(bytes, at + 5, 2))};
    }
    at += marker == 0xff ? 1 : 2 + BigEndian(bytes, at + 2, 2);
  }
  return std::nullopt;
}

Error Wrong(const std::filesystem::path& file, const char* what) {
  return {ErrorCode::kCorrupt, Format("image %s %s", file.c_str(), what)};
}

}  // namespace

Result<GrayImage> ReadGrayImage(const std::filesystem::path& file) {
  const Result<std::string> bytes = ReadFileBytes(file, kLargestFile);
  if (!bytes) return bytes.error();
  std::optional<ImageSize> size = PngSize(*bytes);
  const bool is_png = size.has_value();
  if (!size) size = JpegSize(*bytes);
  if (!size) return Wrong(file, "is neither PNG nor JPEG, expected one of both");
  const size_t pixels = static_cast<size_t>(size->width) * static_cast<size_t>(size->height);
  if (size->width < 1 || size->height < 1 || size->width > kLargestSide ||
      size->height > kLargestSide || pixels > kMostPixelsPerByte * bytes->size()) {
    return Wrong(file, "claims a size that it can't have");
  }
  // The decoder fills what is missing of a file that was cut off.
  if (is_png && bytes->find("IEND", bytes->size() - std::min<size_t>(bytes->size(), 64)) ==
                    std::string::npos) {
    return Wrong(file, "is cut off, expected a whole PNG");
  }
  if (!is_png && bytes->find("\xff\xd9", bytes->size() - std::min<size_t>(bytes->size(), 64)) ==
                     std::string::npos) {
    return Wrong(file, "is cut off, expected a whole JPEG");
  }
  try {
    const cv::Mat buffer(1,
                         static_cast<int>(bytes->size()),
                         CV_8UC1,
                         const_cast<char*>(bytes->data()));  // NOLINT: the decoder reads alone.
    const cv::Mat decoded =
        cv::imdecode(buffer, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
    if (decoded.empty() || decoded.type() != CV_8UC1 || decoded.cols > kLargestSide ||
        decoded.rows > kLargestSide) {
      return Wrong(file, "is damaged, expected an image that can be decoded");
    }
    GrayImage image(decoded.cols, decoded.rows);
    for (int v = 0; v < decoded.rows; ++v) {
      std::copy_n(decoded.ptr<uint8_t>(v), decoded.cols, image.pixels.begin() + v * decoded.cols);
    }
    return image;
  } catch (const cv::Exception& exception) {
    return Wrong(file, Format("can't be decoded: %.200s", exception.what()).c_str());
  }
}

}  // namespace vantage
