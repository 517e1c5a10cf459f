#include "common/depth_codec/depth_encoder.h"

#include <algorithm>
#include <cstring>

#include "common/check.h"
#include "common/depth_codec/crc32c.h"
#include "common/depth_codec/depth_window.h"

namespace vantage {
namespace {

constexpr size_t kSampledRows = 32;  // At least so many rows of a band are counted.

void Store(size_t value, size_t bytes, uint8_t* out) {
  for (size_t i = 0; i < bytes; ++i) out[i] = static_cast<uint8_t>(value >> (8 * i));
}

// A window saves time by the pixels that it leaves out; its numbers take 8 bytes.
bool IsWorthIt(const DepthWindow& window, size_t num_pixels) {
  return 8 * window.width * window.height < 7 * num_pixels;
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
  const auto image_width = static_cast<size_t>(width);
  const size_t stored_bytes = kDepthHeaderBytes + 2 * depth.size();
  payload->resize(kDepthHeaderBytes);
  DepthMode mode = DepthMode::kCoded;
  DepthWindow window{0, 0, image_width, static_cast<size_t>(height)};
  if (const DepthWindow used = FindDepthWindow(depth, image_width); IsWorthIt(used, depth.size())) {
    window = used;
    mode = DepthMode::kWindow;
    for (const size_t number : {used.left, used.top, used.width, used.height}) {
      payload->resize(payload->size() + 2);
      Store(number, 2, payload->data() + payload->size() - 2);
    }
  }
  const DepthLayout layout(static_cast<int>(window.width), static_cast<int>(window.height));
  const std::span<const uint16_t> rows =
      depth.subspan(window.top * image_width, window.height * image_width);
  palette_.Build(rows, image_width, kernels_);
  Tokenize(layout, rows.data() + window.left, image_width);
  CountSymbols(layout);
  AppendTables(payload);
  if (!AppendWords(layout, payload) || payload->size() >= stored_bytes) {
    mode = DepthMode::kStored;
    payload->resize(stored_bytes);
    std::memcpy(payload->data() + kDepthHeaderBytes, depth.data(), 2 * depth.size());
  }
  uint8_t* header = payload->data();
  Store(kDepthMagic, 4, header);
  Store(image_width, 2, header + 8);
  Store(static_cast<size_t>(height), 2, header + 10);
  Store(static_cast<size_t>(mode), 1, header + 12);
  Store(Crc32c(std::span(*payload).subspan(8)), 4, header + 4);
}

void DepthEncoder::Tokenize(const DepthLayout& layout, const uint16_t* depth, size_t stride) {
  ranks_.assign(DepthLayout::kStrips * layout.columns, 0);
  const size_t row_size = DepthLayout::kLanes * layout.columns;
  tokens_.resize(layout.rows * row_size);
  for (size_t band = 0; band < DepthLayout::kBands; ++band) {
    rows_[band].Reset(layout.columns);
    escapes_[band].resize(layout.rows * ranks_.size());
    num_escapes_[band] = 0;
  }
  TokenizeTask task{};
  task.columns = layout.columns;
  task.ranks = ranks_.data();
  for (size_t row = 0; row < layout.rows; ++row) {
    for (size_t band = 0; band < layout.BandsOf(row); ++band) {
      TakeRanks(layout, depth + (row + band * layout.rows) * stride);
      task.above = rows_[band].above();
      task.row = rows_[band].row();
      task.tokens = tokens_.data() + row * row_size + DepthLayout::kStrips * band;
      task.escapes = escapes_[band].data();
      task.num_escapes = num_escapes_[band];
      kernels_.tokenize(&task);
      num_escapes_[band] = task.num_escapes;
      rows_[band].Advance();
    }
  }
}

// Ranks of a row of the image, strip beside strip: four strips at a time, one store for all four.
void DepthEncoder::TakeRanks(const DepthLayout& layout, const uint16_t* depth) {
  const uint16_t* ranks = palette_.ranks();
  const size_t columns = layout.columns;
  constexpr size_t kTogether = 4;
  size_t strip = 0;
  for (; (strip + kTogether) * columns <= layout.width; strip += kTogether) {
    const uint16_t* first = depth + strip * columns;
    uint16_t* out = ranks_.data() + strip;
    for (size_t column = 0; column < columns; ++column, out += DepthLayout::kStrips) {
      uint64_t four = 0;
      for (size_t i = 0; i < kTogether; ++i) {
        four |= uint64_t{ranks[first[i * columns + column]]} << (16 * i);
      }
      std::memcpy(out, &four, sizeof(four));
    }
  }
  for (size_t u = strip * columns; u < layout.width; ++u) {
    ranks_[u % columns * DepthLayout::kStrips + u / columns] = ranks[depth[u]];
  }
}

// Of images with many rows every n-th stands for its neighbours. Four sets of counters, because
// equal tokens that follow each other would wait for each other.
void DepthEncoder::CountSymbols(const DepthLayout& layout) {
  const size_t step = std::max<size_t>(1, layout.rows / kSampledRows);
  const size_t row_size = DepthLayout::kLanes * layout.columns;
  constexpr size_t kSets = 4;
  uint32_t counts[kSets][SymbolTable::kEntries] = {};
  for (size_t row = 0; row < layout.rows; row += step) {
    const uint8_t* tokens = tokens_.data() + row * row_size;
    const size_t lanes = DepthLayout::kStrips * layout.BandsOf(row);
    for (size_t column = 0; column < layout.columns; ++column, tokens += DepthLayout::kLanes) {
      for (size_t lane = 0; lane < lanes; lane += kSets) {
        for (size_t set = 0; set < kSets; ++set) ++counts[set][tokens[lane + set]];
      }
    }
  }
  for (size_t i = 0; i < SymbolTable::kEntries; ++i) {
    uint32_t& count = counts_[i % kDepthContexts][i / kDepthContexts];
    count = 0;
    for (const auto& set : counts) count += set[i];
  }
}

void DepthEncoder::AppendTables(std::vector<uint8_t>* payload) {
  palette_.Append(payload);
  for (size_t context = 0; context < kDepthContexts; ++context) {
    uint16_t frequencies[kDepthSymbols];
    NormalizeFrequencies(counts_[context], frequencies);
    table_.SetContext(context, frequencies);
    AppendFrequencies(frequencies, payload);
  }
  uint32_t buckets[kDepthBuckets] = {};
  for (size_t band = 0; band < DepthLayout::kBands; ++band) {
    for (const uint16_t escape : std::span(escapes_[band]).first(num_escapes_[band])) {
      ++buckets[EscapeBucket(EscapeDistance(escape))];
    }
  }
  uint16_t frequencies[kDepthBuckets];
  NormalizeFrequencies(buckets, frequencies);
  table_.SetBuckets(frequencies);
  AppendFrequencies(frequencies, payload);
}

// False where the image would become larger than it is.
bool DepthEncoder::AppendWords(const DepthLayout& layout, std::vector<uint8_t>* payload) {
  const size_t row_size = DepthLayout::kLanes * layout.columns;
  words_.resize((layout.rows + kWordsPerPixel) * row_size);
  uint32_t states[DepthLayout::kLanes];
  std::ranges::fill(states, kDepthStateLow);
  uint16_t* const end = words_.data() + words_.size();
  EncodeTask task{};
  task.columns = layout.columns;
  task.table = &table_;
  for (size_t band = 0; band < DepthLayout::kBands; ++band) {
    task.escapes[band] = escapes_[band].data() + num_escapes_[band];
  }
  task.states = states;
  task.words = end;
  for (size_t row = layout.rows; row-- > 0;) {
    if (static_cast<size_t>(task.words - words_.data()) < kWordsPerPixel * row_size) return false;
    task.bands = layout.BandsOf(row);
    task.tokens = tokens_.data() + row * row_size;
    kernels_.encode(&task);
  }
  const auto num_words = static_cast<size_t>(end - task.words);
  const size_t before = payload->size();
  payload->resize(before + sizeof(states) + 2 * num_words);
  std::memcpy(payload->data() + before, states, sizeof(states));
  std::memcpy(payload->data() + before + sizeof(states), task.words, 2 * num_words);
  return true;
}

}  // namespace vantage
