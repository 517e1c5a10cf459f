#include "bus/image_conversion.h"

#include <zlib.h>

#include <algorithm>
#include <vector>

#include "bus/message_time.h"
#include "common/check.h"
#include "common/depth_codec/depth_decoder.h"
#include "common/depth_codec/depth_encoder.h"
#include "common/format.h"

namespace vantage {
namespace {

constexpr size_t kMaxZlibRatio = 1032;  // deflate never expands more (zlib's technical notes)
static_assert(kMaxImageSide <= kMaxDepthSide);

Error Malformed(const image_t& image, const std::string& expected) {
  return {ErrorCode::kCorrupt,
          Format("depth image of %d x %d px, row stride %d, %zu bytes: expected %s",
                 image.width,
                 image.height,
                 image.row_stride,
                 image.data.size(),
                 expected.c_str())};
}

// Exactly `size` bytes, or nothing. Allocates no more than the stream can hold.
bool Inflate(const std::vector<uint8_t>& stream, size_t size, std::vector<uint8_t>* bytes) {
  if (size > kMaxZlibRatio * (stream.size() + 1)) return false;
  bytes->resize(size);
  uLongf length = size;
  uLong consumed = stream.size();
  return uncompress2(bytes->data(), &length, stream.data(), &consumed) == Z_OK && length == size &&
         consumed == stream.size();
}

uint16_t LoadLittleEndian16(const uint8_t* bytes) {
  return static_cast<uint16_t>(bytes[0] | (bytes[1] << 8));
}

std::vector<uint8_t> ToBytes(std::span<const uint16_t> values) {
  std::vector<uint8_t> bytes(2 * values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    bytes[2 * i] = static_cast<uint8_t>(values[i] & 0xffU);
    bytes[2 * i + 1] = static_cast<uint8_t>(values[i] >> 8U);
  }
  return bytes;
}

std::vector<uint8_t> Deflate(const std::vector<uint8_t>& bytes) {
  uLongf length = compressBound(bytes.size());
  std::vector<uint8_t> stream(length);
  const int status = compress2(stream.data(), &length, bytes.data(), bytes.size(), 1);
  VANTAGE_CHECK(status == Z_OK, "zlib refuses a buffer of its own bound");
  stream.resize(length);
  return stream;
}

image_metadata_t Metadata(const std::string& key, std::vector<uint8_t> value) {
  image_metadata_t metadata{};
  metadata.key = key;
  metadata.n = static_cast<int32_t>(value.size());
  metadata.value = std::move(value);
  return metadata;
}

const image_metadata_t* FindMetadata(const image_t& image, const std::string& key) {
  const auto found = std::ranges::find(image.metadata, key, &image_metadata_t::key);
  return found == image.metadata.end() ? nullptr : &*found;
}

bool IsDepth(int16_t type) {
  return type == images_t::DEPTH_MM || type == images_t::DEPTH_MM_ZIPPED ||
         type == images_t::DEPTH_MM_VDC;
}

DepthImage FromMillimetres(int width, int height, const uint8_t* bytes, size_t stride) {
  DepthImage depth(width, height);
  for (size_t v = 0; v < static_cast<size_t>(height); ++v) {
    float* row = &depth.depth[v * static_cast<size_t>(width)];
    for (size_t u = 0; u < static_cast<size_t>(width); ++u) {
      const uint16_t millimetres = LoadLittleEndian16(bytes + v * stride + 2 * u);
      row[u] = millimetres != 0 ? 1e-3F * static_cast<float>(millimetres) : DepthImage::kInvalid;
    }
  }
  return depth;
}

// Its buffers are kept for the thread's next image.
Result<DepthImage> DepthFromVdc(const image_t& image) {
  thread_local DepthDecoder decoder;
  thread_local std::vector<uint16_t> millimetres;
  const Result<void> decoded = decoder.Decode(image.data, image.width, image.height, &millimetres);
  if (!decoded) return decoded.error();
  return FromMillimetres(image.width,
                         image.height,
                         reinterpret_cast<const uint8_t*>(millimetres.data()),
                         2 * static_cast<size_t>(image.width));
}

std::vector<uint8_t> EncodeVdc(int width, int height, std::span<const uint16_t> millimetres) {
  thread_local DepthEncoder encoder;
  return encoder.Encode(width, height, millimetres);
}

Result<DepthImage> DepthFromImage(const image_t& image, int16_t type) {
  if (image.width < 1 || image.height < 1 || image.width > kMaxImageSide ||
      image.height > kMaxImageSide) {
    return Malformed(image, Format("sides of 1 to %d px", kMaxImageSide));
  }
  const size_t width = static_cast<size_t>(image.width);
  const size_t height = static_cast<size_t>(image.height);
  const size_t row = 2 * width;
  const size_t stride = image.row_stride < 0 ? 0 : static_cast<size_t>(image.row_stride);
  if (type == images_t::DEPTH_MM) {
    if (stride < row || image.data.size() != stride * height) {
      return Malformed(image, Format("a row stride of %zu or more, times height in bytes", row));
    }
    return FromMillimetres(image.width, image.height, image.data.data(), stride);
  }
  if (stride != row) return Malformed(image, Format("a row stride of %zu", row));
  if (type == images_t::DEPTH_MM_VDC) return DepthFromVdc(image);
  std::vector<uint8_t> inflated;
  if (!Inflate(image.data, row * height, &inflated)) {
    return Malformed(image, Format("a zlib stream of exactly %zu bytes", row * height));
  }
  return FromMillimetres(image.width, image.height, inflated.data(), row);
}

}  // namespace

Result<DepthFrame> DepthFrameFromMessage(const images_t& message) {
  if (Result<void> timed = CheckUtime("images_t.utime", message.utime); !timed) {
    return timed.error();
  }
  const size_t num_images = std::min(message.images.size(), message.image_types.size());
  for (size_t i = 0; i < num_images; ++i) {
    if (!IsDepth(message.image_types[i])) continue;
    const image_t& image = message.images[i];
    Result<DepthImage> depth = DepthFromImage(image, message.image_types[i]);
    if (!depth) return depth.error();
    DepthFrame frame{.utime = message.utime,
                     .seq = ImageSeq(image),
                     .serial = {},
                     .image = std::move(depth).value()};
    if (const image_metadata_t* serial = FindMetadata(image, "serial"); serial != nullptr) {
      frame.serial.assign(serial->value.begin(), serial->value.end());
    }
    return frame;
  }
  return Error{ErrorCode::kNotFound,
               Format("images_t with %zu images has no depth, expected one of type %d, %d or %d",
                      num_images,
                      images_t::DEPTH_MM,
                      images_t::DEPTH_MM_ZIPPED,
                      images_t::DEPTH_MM_VDC)};
}

images_t DepthToMessage(int width,
                        int height,
                        std::span<const uint16_t> millimetres,
                        int64_t utime,
                        int64_t seq,
                        const std::string& serial,
                        DepthCompression compression) {
  VANTAGE_CHECK(width > 0 && height > 0 &&
                    millimetres.size() == static_cast<size_t>(width) * static_cast<size_t>(height),
                "a depth image has width * height values");
  image_t image{};
  image.utime = utime;
  image.width = width;
  image.height = height;
  image.row_stride = 2 * width;
  image.pixelformat = image_t::PIXEL_FORMAT_INVALID;
  int16_t type = images_t::DEPTH_MM;
  switch (compression) {
    case DepthCompression::kNone:
      image.data = ToBytes(millimetres);
      break;
    case DepthCompression::kZlib:
      type = images_t::DEPTH_MM_ZIPPED;
      image.data = Deflate(ToBytes(millimetres));
      break;
    case DepthCompression::kVdc:
      type = images_t::DEPTH_MM_VDC;
      image.data = EncodeVdc(width, height, millimetres);
      break;
  }
  AppendIdentity(seq, serial, &image);

  images_t message{};
  message.utime = utime;
  AppendImage(type, std::move(image), &message);
  return message;
}

size_t BytesPerPixel(int32_t pixelformat) {
  switch (pixelformat) {
    case image_t::PIXEL_FORMAT_GRAY:
      return 1;
    case image_t::PIXEL_FORMAT_RGB:
    case image_t::PIXEL_FORMAT_BGR:
      return 3;
    default:
      return 0;
  }
}

void AppendIdentity(int64_t seq, const std::string& serial, image_t* image) {
  std::vector<uint8_t> seq_bytes(8);
  for (size_t i = 0; i < 8; ++i) {
    seq_bytes[i] = static_cast<uint8_t>((static_cast<uint64_t>(seq) >> (8 * i)) & 0xffU);
  }
  image->metadata.push_back(Metadata("seq", std::move(seq_bytes)));
  image->metadata.push_back(Metadata("serial", {serial.begin(), serial.end()}));
}

void AppendImage(int16_t type, image_t image, images_t* message) {
  image.size = static_cast<int32_t>(image.data.size());
  image.nmetadata = static_cast<int32_t>(image.metadata.size());
  message->image_types.push_back(type);
  message->images.push_back(std::move(image));
  message->n_images = static_cast<int32_t>(message->images.size());
}

int64_t ImageSeq(const image_t& image) {
  const image_metadata_t* metadata = FindMetadata(image, "seq");
  if (metadata == nullptr || metadata->value.size() != 8) return -1;
  uint64_t seq = 0;
  for (size_t i = 8; i-- > 0;) seq = (seq << 8U) | metadata->value[i];
  return static_cast<int64_t>(seq);
}

}  // namespace vantage
