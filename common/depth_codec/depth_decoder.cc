#include "common/depth_codec/depth_decoder.h"

#include <algorithm>
#include <cstring>

#include "common/check.h"
#include "common/depth_codec/crc32c.h"
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
  if (Load(payload.data(), 4) != kDepthMagic) {
    return corrupt("it does not begin with \"VDC\" and version 1");
  }
  if (Load(payload.data() + 4, 4) != Crc32c(payload.subspan(8))) {
    return corrupt("its checksum does not fit its bytes");
  }
  const DepthLayout layout(width, height);
  const size_t its_width = Load(payload.data() + 8, 2);
  const size_t its_height = Load(payload.data() + 10, 2);
  if (its_width != layout.width || its_height != layout.height) {
    return corrupt(
        Format("it is %zu x %zu px, expected %d x %d", its_width, its_height, width, height));
  }
  depth->resize(layout.width * layout.height);
  const std::span<const uint8_t> bytes = payload.subspan(kDepthHeaderBytes);
  std::string wrong;
  switch (static_cast<DepthMode>(payload[12])) {
    case DepthMode::kStored:
      wrong = DecodeStored(bytes, depth);
      break;
    case DepthMode::kCoded:
      wrong = DecodeCoded(layout, bytes, depth->data(), layout.width);
      break;
    case DepthMode::kWindow:
      wrong = DecodeWindow(layout, bytes, depth);
      break;
    default:
      wrong = Format("its mode is %d, expected 0 to 2", payload[12]);
  }
  if (!wrong.empty()) return corrupt(wrong);
  return {};
}

std::string DepthDecoder::DecodeStored(std::span<const uint8_t> bytes,
                                       std::vector<uint16_t>* depth) {
  if (bytes.size() != 2 * depth->size()) {
    return Format("it has %zu bytes of pixels, expected %zu", bytes.size(), 2 * depth->size());
  }
  std::memcpy(depth->data(), bytes.data(), bytes.size());
  return {};
}

std::string DepthDecoder::DecodeWindow(const DepthLayout& image,
                                       std::span<const uint8_t> bytes,
                                       std::vector<uint16_t>* depth) {
  constexpr size_t kBytes = 8;
  if (bytes.size() < kBytes) return "its window is cut off";
  const size_t left = Load(bytes.data(), 2);
  const size_t top = Load(bytes.data() + 2, 2);
  const size_t width = Load(bytes.data() + 4, 2);
  const size_t height = Load(bytes.data() + 6, 2);
  if (width == 0 || height == 0 || left + width > image.width || top + height > image.height) {
    return Format("its window is %zu x %zu px at (%zu, %zu)", width, height, left, top);
  }
  std::ranges::fill(*depth, uint16_t{0});
  const DepthLayout layout(static_cast<int>(width), static_cast<int>(height));
  return DecodeCoded(
      layout, bytes.subspan(kBytes), depth->data() + top * image.width + left, image.width);
}

std::string DepthDecoder::DecodeCoded(const DepthLayout& layout,
                                      std::span<const uint8_t> bytes,
                                      uint16_t* depth,
                                      size_t stride) {
  if (!palette_.Read(&bytes)) return "its palette is damaged";
  if (!ReadTables(&bytes)) return "its frequencies are damaged";
  if (bytes.size() < sizeof(states_) || bytes.size() % 2 != 0) {
    return Format("expected %zu bytes of states and then words of 2, %zu are left",
                  sizeof(states_),
                  bytes.size());
  }
  std::memcpy(states_, bytes.data(), sizeof(states_));
  bytes = bytes.subspan(sizeof(states_));
  if (std::ranges::any_of(states_, [](uint32_t state) { return state < kDepthStateLow; })) {
    return "a state is out of range";
  }
  // What a row may read at most follows the words, so that it is enough to look after each row.
  const size_t num_words = bytes.size() / 2;
  const size_t padding = kWordsPerPixel * DepthLayout::kLanes * (layout.columns + 1);
  words_.resize(num_words + padding);
  if (num_words > 0) std::memcpy(words_.data(), bytes.data(), bytes.size());
  std::fill(words_.end() - static_cast<std::ptrdiff_t>(padding), words_.end(), uint16_t{0});
  if (!DecodeRows(layout, num_words, depth, stride)) return "its pixels are damaged";
  return {};
}

bool DepthDecoder::ReadTables(std::span<const uint8_t>* bytes) {
  if (bytes->size() < SymbolTable::kEntries + kDepthBuckets) return false;
  for (size_t context = 0; context < kDepthContexts; ++context) {
    uint16_t frequencies[kDepthSymbols];
    if (!ReadFrequencies(bytes->first(kDepthSymbols), frequencies)) return false;
    table_.SetContext(context, frequencies);
    *bytes = bytes->subspan(kDepthSymbols);
  }
  uint16_t frequencies[kDepthBuckets];
  if (!ReadFrequencies(bytes->first(kDepthBuckets), frequencies)) return false;
  table_.SetBuckets(frequencies);
  *bytes = bytes->subspan(kDepthBuckets);
  return true;
}

bool DepthDecoder::DecodeRows(const DepthLayout& layout,
                              size_t num_words,
                              uint16_t* depth,
                              size_t stride) {
  DecodeTask task{};
  task.columns = layout.columns;
  task.num_ranks = palette_.size();
  task.table = &table_;
  task.states = states_;
  task.words = words_.data();
  task.sound = true;
  for (size_t band = 0; band < DepthLayout::kBands; ++band) {
    rows_[band].Reset(layout.columns);
    ranks_[band].resize(DepthLayout::kStrips * layout.columns);
    task.ranks[band] = ranks_[band].data();
  }
  for (size_t row = 0; row < layout.rows; ++row) {
    task.bands = layout.BandsOf(row);
    for (size_t band = 0; band < task.bands; ++band) {
      task.above[band] = rows_[band].above();
      task.row[band] = rows_[band].row();
    }
    kernels_.decode(&task);
    if (!task.sound || task.words > words_.data() + num_words) return false;
    for (size_t band = 0; band < task.bands; ++band) {
      rows_[band].Advance();
      PutRow(layout, task.ranks[band], depth + (row + band * layout.rows) * stride);
    }
  }
  // The encoder began with these states and no words.
  return task.words == words_.data() + num_words &&
         std::ranges::all_of(states_, [](uint32_t state) { return state == kDepthStateLow; });
}

// Four columns at a time, one store for all four.
void DepthDecoder::PutRow(const DepthLayout& layout, const uint16_t* ranks, uint16_t* depth) const {
  const uint16_t* values = palette_.values();
  constexpr size_t kTogether = 4;
  for (size_t strip = 0, u = 0; u < layout.width; ++strip) {
    const uint16_t* in = ranks + strip;
    const size_t end = std::min(u + layout.columns, layout.width);
    for (; u + kTogether <= end; u += kTogether) {
      uint64_t four = 0;
      for (size_t i = 0; i < kTogether; ++i, in += DepthLayout::kStrips) {
        four |= uint64_t{values[*in]} << (16 * i);
      }
      std::memcpy(depth + u, &four, sizeof(four));
    }
    for (; u < end; ++u, in += DepthLayout::kStrips) depth[u] = values[*in];
  }
}

}  // namespace vantage
