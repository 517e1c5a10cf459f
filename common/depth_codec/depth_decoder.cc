#include "common/depth_codec/depth_decoder.h"

#include "common/check.h"
#include "common/depth_codec/crc32c.h"
#include "common/depth_codec/depth_payload.h"
#include "common/format.h"

namespace vantage {
namespace {

uint32_t Load(const uint8_t* bytes, size_t count) {
  uint32_t value = 0;
  for (size_t i = count; i-- > 0;) value = (value << 8U) | bytes[i];
  return value;
}

}  // namespace

Result<void> DepthDecoder::Decode(std::span<const uint8_t> payload,
                                  int width,
                                  int height,
                                  std::vector<uint16_t>* depth) {
  VANTAGE_CHECK(width > 0 && height > 0 && width <= kMaxDepthSide && height <= kMaxDepthSide,
                "a depth image has sides of 1 to 4096 px");
  const auto corrupt = [&](const std::string& what) {
    return Error{ErrorCode::kCorrupt,
                 Format("compressed depth of %zu bytes: %s", payload.size(), what.c_str())};
  };
  if (payload.size() < kDepthHeaderBytes) {
    return corrupt(Format("expected a header of %zu", kDepthHeaderBytes));
  }
  if (Load(payload.data(), 4) != kDepthMagic) return corrupt("expected to begin with \"VDC\\1\"");
  if (Load(payload.data() + 4, 4) != Crc32c(payload.subspan(8))) {
    return corrupt("its checksum does not fit its bytes");
  }
  const uint32_t its_width = Load(payload.data() + 8, 2);
  const uint32_t its_height = Load(payload.data() + 10, 2);
  if (its_width != static_cast<uint32_t>(width) || its_height != static_cast<uint32_t>(height)) {
    return corrupt(
        Format("it is %u x %u px, expected %d x %d", its_width, its_height, width, height));
  }
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  if (payload[12] != static_cast<uint8_t>(DepthMode::kStored)) {
    return corrupt(Format("its mode is %d, expected 0", payload[12]));
  }
  if (payload.size() != kDepthHeaderBytes + 2 * pixels) {
    return corrupt(Format("expected %zu", kDepthHeaderBytes + 2 * pixels));
  }
  depth->resize(pixels);
  for (size_t i = 0; i < pixels; ++i) {
    (*depth)[i] = static_cast<uint16_t>(Load(payload.data() + kDepthHeaderBytes + 2 * i, 2));
  }
  return {};
}

}  // namespace vantage
