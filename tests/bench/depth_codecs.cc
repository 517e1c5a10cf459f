#include "tests/bench/depth_codecs.h"

#include <lz4.h>
#include <png.h>
#include <zlib.h>
#include <zstd.h>

#include <cstring>
#include <memory>
#include <string>

#include "common/depth_codec/depth_decoder.h"
#include "common/depth_codec/depth_encoder.h"
#include "tests/bench/rvl.h"

namespace vantage {
namespace {

constexpr int kZstdLevel = 1;

// Contexts and buffers are kept, which is zstd's fastest use.
class Zstd {
 public:
  void Compress(std::span<const uint8_t> plain, std::vector<uint8_t>* bytes) {
    bytes->resize(ZSTD_compressBound(plain.size()));
    bytes->resize(ZSTD_compressCCtx(
        compressor_.get(), bytes->data(), bytes->size(), plain.data(), plain.size(), kZstdLevel));
  }
  // The number of bytes, 0 where there are none.
  size_t Expand(std::span<const uint8_t> bytes, std::span<uint8_t> plain) {
    const size_t size = ZSTD_decompressDCtx(
        expander_.get(), plain.data(), plain.size(), bytes.data(), bytes.size());
    return ZSTD_isError(size) != 0 ? 0 : size;
  }

 private:
  struct Free {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
  };
  std::unique_ptr<ZSTD_CCtx, Free> compressor_{ZSTD_createCCtx()};
  std::unique_ptr<ZSTD_DCtx, Free> expander_{ZSTD_createDCtx()};
};

std::span<const uint8_t> AsBytes(std::span<const uint16_t> depth) {
  return {reinterpret_cast<const uint8_t*>(depth.data()), 2 * depth.size()};
}

std::span<uint8_t> AsWritableBytes(std::vector<uint16_t>* depth) {
  return {reinterpret_cast<uint8_t*>(depth->data()), 2 * depth->size()};
}

DepthCodecRow Ours() {
  const auto encoder = std::make_shared<DepthEncoder>();
  const auto decoder = std::make_shared<DepthDecoder>();
  return {"vantage",
          [encoder](const DepthFrames& set, auto depth, auto* bytes) {
            encoder->Encode(set.width, set.height, depth, bytes);
          },
          [decoder](const DepthFrames& set, auto bytes, auto* depth) {
            return decoder->Decode(bytes, set.width, set.height, depth).ok();
          }};
}

DepthCodecRow Rvl() {
  return {"rvl",
          [](const DepthFrames&, auto depth, auto* bytes) { EncodeRvl(depth, bytes); },
          [](const DepthFrames&, auto bytes, auto* depth) { return DecodeRvl(bytes, *depth); }};
}

DepthCodecRow ZstdAlone() {
  const auto zstd = std::make_shared<Zstd>();
  return {"zstd1",
          [zstd](const DepthFrames&, auto depth, auto* bytes) {
            zstd->Compress(AsBytes(depth), bytes);
          },
          [zstd](const DepthFrames&, auto bytes, auto* depth) {
            return zstd->Expand(bytes, AsWritableBytes(depth)) == 2 * depth->size();
          }};
}

DepthCodecRow RvlAndZstd() {
  const auto zstd = std::make_shared<Zstd>();
  const auto nibbles = std::make_shared<std::vector<uint8_t>>();
  return {"rvl+zstd1",
          [zstd, nibbles](const DepthFrames&, auto depth, auto* bytes) {
            EncodeRvl(depth, nibbles.get());
            zstd->Compress(*nibbles, bytes);
          },
          [zstd, nibbles](const DepthFrames&, auto bytes, auto* depth) {
            nibbles->resize(4 * depth->size() + 64);
            const size_t size = zstd->Expand(bytes, *nibbles);
            return DecodeRvl(std::span(*nibbles).first(size), *depth);
          }};
}

DepthCodecRow Zlib() {
  return {"zlib1",
          [](const DepthFrames&, auto depth, auto* bytes) {
            const std::span<const uint8_t> plain = AsBytes(depth);
            uLongf size = compressBound(plain.size());
            bytes->resize(size);
            compress2(bytes->data(), &size, plain.data(), plain.size(), 1);
            bytes->resize(size);
          },
          [](const DepthFrames&, auto bytes, auto* depth) {
            const std::span<uint8_t> plain = AsWritableBytes(depth);
            uLongf size = plain.size();
            return uncompress(plain.data(), &size, bytes.data(), bytes.size()) == Z_OK &&
                   size == plain.size();
          }};
}

DepthCodecRow Lz4() {
  return {"lz4",
          [](const DepthFrames&, auto depth, auto* bytes) {
            const std::span<const uint8_t> plain = AsBytes(depth);
            const int size = static_cast<int>(plain.size());
            bytes->resize(static_cast<size_t>(LZ4_compressBound(size)));
            const int written = LZ4_compress_default(reinterpret_cast<const char*>(plain.data()),
                                                     reinterpret_cast<char*>(bytes->data()),
                                                     size,
                                                     static_cast<int>(bytes->size()));
            bytes->resize(static_cast<size_t>(written));
          },
          [](const DepthFrames&, auto bytes, auto* depth) {
            const std::span<uint8_t> plain = AsWritableBytes(depth);
            const int size = static_cast<int>(plain.size());
            return LZ4_decompress_safe(reinterpret_cast<const char*>(bytes.data()),
                                       reinterpret_cast<char*>(plain.data()),
                                       static_cast<int>(bytes.size()),
                                       size) == size;
          }};
}

// Differences along the row, folded to be positive; their low bytes, then their high ones.
void SplitDifferences(std::span<const uint16_t> depth, std::vector<uint8_t>* planes) {
  planes->resize(2 * depth.size());
  uint8_t* low = planes->data();
  uint8_t* high = low + depth.size();
  uint16_t previous = 0;
  for (size_t i = 0; i < depth.size(); ++i) {
    const auto difference = static_cast<int16_t>(static_cast<uint16_t>(depth[i] - previous));
    const auto folded = static_cast<uint16_t>((difference << 1) ^ (difference >> 15));
    low[i] = static_cast<uint8_t>(folded & 0xffU);
    high[i] = static_cast<uint8_t>(folded >> 8U);
    previous = depth[i];
  }
}

void JoinDifferences(std::span<const uint8_t> planes, std::span<uint16_t> depth) {
  const uint8_t* low = planes.data();
  const uint8_t* high = low + depth.size();
  uint16_t previous = 0;
  for (size_t i = 0; i < depth.size(); ++i) {
    const unsigned folded = low[i] | (unsigned{high[i]} << 8U);
    previous = static_cast<uint16_t>(previous + ((folded >> 1U) ^ (0U - (folded & 1U))));
    depth[i] = previous;
  }
}

DepthCodecRow DeltaSplitZstd() {
  const auto zstd = std::make_shared<Zstd>();
  const auto planes = std::make_shared<std::vector<uint8_t>>();
  return {"delta+split+zstd1",
          [zstd, planes](const DepthFrames&, auto depth, auto* bytes) {
            SplitDifferences(depth, planes.get());
            zstd->Compress(*planes, bytes);
          },
          [zstd, planes](const DepthFrames&, auto bytes, auto* depth) {
            planes->resize(2 * depth->size());
            if (zstd->Expand(bytes, *planes) != planes->size()) return false;
            JoinDifferences(*planes, *depth);
            return true;
          }};
}

void AppendBytes(png_structp png, png_bytep data, size_t size) {
  auto* bytes = static_cast<std::vector<uint8_t>*>(png_get_io_ptr(png));
  bytes->insert(bytes->end(), data, data + size);
}

void TakeBytes(png_structp png, png_bytep data, size_t size) {
  auto* left = static_cast<std::span<const uint8_t>*>(png_get_io_ptr(png));
  if (size > left->size()) png_error(png, "too short");
  std::memcpy(data, left->data(), size);
  *left = left->subspan(size);
}

// An error ends the program: nothing but its own images comes here.
void EncodePng(const DepthFrames& set,
               int level,
               std::span<const uint16_t> depth,
               std::vector<uint8_t>* bytes) {
  bytes->clear();
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, bytes, AppendBytes, nullptr);
  png_set_compression_level(png, level);
  png_set_IHDR(png,
               info,
               static_cast<png_uint_32>(set.width),
               static_cast<png_uint_32>(set.height),
               16,
               PNG_COLOR_TYPE_GRAY,
               PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  png_set_swap(png);
  const std::span<const uint8_t> plain = AsBytes(depth);
  const size_t row = 2 * static_cast<size_t>(set.width);
  for (size_t at = 0; at < plain.size(); at += row) png_write_row(png, &plain[at]);
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
}

void DecodePng(const DepthFrames& set, std::span<const uint8_t> bytes, std::span<uint8_t> plain) {
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_read_fn(png, &bytes, TakeBytes);
  png_read_info(png, info);
  png_set_swap(png);
  const size_t row = 2 * static_cast<size_t>(set.width);
  for (size_t at = 0; at < plain.size(); at += row) png_read_row(png, &plain[at], nullptr);
  png_destroy_read_struct(&png, &info, nullptr);
}

DepthCodecRow Png(int level) {
  return {"png" + std::to_string(level),
          [level](const DepthFrames& set, auto depth, auto* bytes) {
            EncodePng(set, level, depth, bytes);
          },
          [](const DepthFrames& set, auto bytes, auto* depth) {
            DecodePng(set, bytes, AsWritableBytes(depth));
            return true;
          }};
}

}  // namespace

std::vector<DepthCodecRow> MakeDepthCodecs() {
  return {Ours(),
          Rvl(),
          RvlAndZstd(),
          DeltaSplitZstd(),
          ZstdAlone(),
          Lz4(),
          Zlib(),
          Png(1),   // The fastest that compresses.
          Png(6)};  // The default.
}

}  // namespace vantage
