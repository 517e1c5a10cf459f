// Depth images through our codec and through others: encode/SET/CODEC and decode/SET/CODEC. The
// time is that of one frame; `to_1` says how many times smaller the set became.
#include <benchmark/benchmark.h>

#include "tests/bench/depth_codecs.h"
#include "tests/bench/table_frames.h"

namespace vantage {
namespace {

DepthFrames SimulatedFrames() {
  constexpr int kFrames = 8;
  DepthFrames set{.name = "simulated", .width = 640, .height = 480, .frames = {}};
  for (int number = 0; number < kFrames; ++number) {
    std::vector<uint16_t>& frame = set.frames.emplace_back();
    for (const float z : MakeTableFrame(number).depth.depth) {
      frame.push_back(z > 0.0F ? static_cast<uint16_t>(1e3F * z + 0.5F) : uint16_t{0});
    }
  }
  return set;
}

using Payloads = std::vector<std::vector<uint8_t>>;

Payloads EncodeAll(const DepthFrames& set, const DepthCodecRow& codec) {
  Payloads payloads(set.frames.size());
  for (size_t i = 0; i < payloads.size(); ++i) codec.encode(set, set.frames[i], &payloads[i]);
  return payloads;
}

double Ratio(const DepthFrames& set, const Payloads& payloads) {
  size_t before = 0;
  size_t after = 0;
  for (const auto& frame : set.frames) before += 2 * frame.size();
  for (const auto& payload : payloads) after += payload.size();
  return static_cast<double>(before) / static_cast<double>(after);
}

void Encode(benchmark::State& state, const DepthFrames& set, const DepthCodecRow& codec) {
  state.counters["to_1"] = Ratio(set, EncodeAll(set, codec));
  std::vector<uint8_t> payload;
  size_t i = 0;
  for (auto _ : state) {
    codec.encode(set, set.frames[i++ % set.frames.size()], &payload);
    benchmark::DoNotOptimize(payload.data());
  }
}

void Decode(benchmark::State& state, const DepthFrames& set, const DepthCodecRow& codec) {
  const Payloads payloads = EncodeAll(set, codec);
  std::vector<uint16_t> depth(set.frames.front().size());
  for (size_t i = 0; i < payloads.size(); ++i) {
    if (!codec.decode(set, payloads[i], &depth) || depth != set.frames[i]) {
      state.SkipWithError("an image did not come back as it was");
    }
  }
  size_t i = 0;
  for (auto _ : state) {
    codec.decode(set, payloads[i++ % payloads.size()], &depth);
    benchmark::DoNotOptimize(depth.data());
  }
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  const std::vector<vantage::DepthFrames> sets = {vantage::SimulatedFrames()};
  const std::vector<vantage::DepthCodecRow> codecs = vantage::MakeDepthCodecs();
  for (const auto& set : sets) {
    for (const auto& codec : codecs) {
      const std::string name = set.name + "/" + codec.name;
      benchmark::RegisterBenchmark(("encode/" + name).c_str(), [&](benchmark::State& state) {
        vantage::Encode(state, set, codec);
      })->Unit(benchmark::kMillisecond);
      benchmark::RegisterBenchmark(("decode/" + name).c_str(), [&](benchmark::State& state) {
        vantage::Decode(state, set, codec);
      })->Unit(benchmark::kMillisecond);
    }
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
