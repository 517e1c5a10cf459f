#include "common/depth_codec/depth_encoder.h"

#include "common/check.h"
#include "common/depth_codec/crc32c.h"
#include "common/depth_codec/depth_payload.h"

namespace vantage {
namespace {

void Store(uint32_t value, size_t bytes, uint8_t* out) {
  for (size_t i = 0; i < bytes; ++i) out[i] = static_cast<uint8_t>(value >> (8 * i));
}

}  // namespace

std::vector<uint8_t> DepthEncoder::Encode(int width, int height, std::span<const uint16_t> depth) {
  std::vector<uint8_t> payload;
  Encode(width, height, depth, &payload);
  return payload;
}

void DepthEncoder::Encode(int width,
                          int height,
                          std::span<const uint16_t> depth,
                          std::vector<uint8_t>* payload) {
  VANTAGE_CHECK(width > 0 && height > 0 && width <= kMaxDepthSide && height <= kMaxDepthSide &&
                    depth.size() == static_cast<size_t>(width) * static_cast<size_t>(height),
                "a depth image has width * height values");
  payload->resize(kDepthHeaderBytes + 2 * depth.size());
  uint8_t* out = payload->data();
  Store(kDepthMagic, 4, out);
  Store(static_cast<uint32_t>(width), 2, out + 8);
  Store(static_cast<uint32_t>(height), 2, out + 10);
  Store(static_cast<uint32_t>(DepthMode::kStored), 1, out + 12);
  for (size_t i = 0; i < depth.size(); ++i) Store(depth[i], 2, out + kDepthHeaderBytes + 2 * i);
  Store(Crc32c(std::span(*payload).subspan(8)), 4, out + 4);
}

}  // namespace vantage
