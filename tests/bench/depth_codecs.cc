#include "tests/bench/depth_codecs.h"

#include <zstd.h>

#include <memory>

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

}  // namespace

std::vector<DepthCodecRow> MakeDepthCodecs() { return {Ours(), Rvl(), RvlAndZstd(), ZstdAlone()}; }

}  // namespace vantage
