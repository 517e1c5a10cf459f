// Depth images through our codec and through others: encode/SET/CODEC and decode/SET/CODEC. The
// time is that of one frame; `to_1` says how many times smaller the set became, and of ours
// `by_best_peer` by how much more than by the best of the others.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/depth_codecs.h"
#include "tests/bench/table_frames.h"
#include "tools/support/png_image.h"

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

// 16-bit images of a folder, of the size of the first; none where the folder is absent.
DepthFrames RecordedFrames(const std::string& name, const std::string& folder) {
  namespace fs = std::filesystem;
  DepthFrames set{.name = name, .width = 0, .height = 0, .frames = {}};
  std::vector<fs::path> files;
  std::error_code error;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(fs::path(VANTAGE_SOURCE_DIR) / "../shared/data" / folder, error)) {
    const std::string file = entry.path().filename().string();
    if (file.find("depth") != std::string::npos && file.ends_with(".png")) {
      files.push_back(entry.path());
    }
  }
  std::ranges::sort(files);
  for (const fs::path& file : files) {
    Result<Gray16Image> image = ReadPng16(file);
    if (!image) continue;
    if (set.frames.empty()) {
      set.width = image->width;
      set.height = image->height;
    }
    if (image->width != set.width || image->height != set.height) continue;
    set.frames.push_back(std::move(image->gray));
  }
  if (set.frames.empty()) std::printf("left out: %s, which is not there\n", folder.c_str());
  return set;
}

std::vector<DepthFrames> AllSets() {
  std::vector<DepthFrames> sets = {SimulatedFrames()};
  for (const auto& [name, folder] : {std::pair("room", "tsdf_fusion_rgbd_50frames/rgbd-frames"),
                                     std::pair("bunny", "bunny_turntable_36views"),
                                     std::pair("shelf", "apc_shelf_binE_15views"),
                                     std::pair("clutter", "ycbv_two_frames")}) {
    DepthFrames set = RecordedFrames(name, folder);
    if (!set.frames.empty()) sets.push_back(std::move(set));
  }
  return sets;
}

// A set through a codec.
struct Coded {
  std::vector<std::vector<uint8_t>> payloads;
  double to_1 = 0.0;
  bool is_lossless = true;
};

Coded EncodeAll(const DepthFrames& set, const DepthCodecRow& codec) {
  Coded coded;
  size_t before = 0;
  size_t after = 0;
  std::vector<uint16_t> back(set.frames.front().size());
  for (const std::vector<uint16_t>& frame : set.frames) {
    std::vector<uint8_t>& payload = coded.payloads.emplace_back();
    codec.encode(set, frame, &payload);
    before += 2 * frame.size();
    after += payload.size();
    if (!codec.decode(set, payload, &back) || back != frame) coded.is_lossless = false;
  }
  coded.to_1 = static_cast<double>(before) / static_cast<double>(after);
  return coded;
}

void Encode(benchmark::State& state, const DepthFrames& set, const DepthCodecRow& codec) {
  std::vector<uint8_t> payload;
  size_t i = 0;
  for (auto _ : state) {
    codec.encode(set, set.frames[i++ % set.frames.size()], &payload);
    benchmark::DoNotOptimize(payload.data());
  }
}

void Decode(benchmark::State& state,
            const DepthFrames& set,
            const DepthCodecRow& codec,
            const Coded& coded) {
  if (!coded.is_lossless) state.SkipWithError("an image did not come back as it was");
  std::vector<uint16_t> depth(set.frames.front().size());
  size_t i = 0;
  for (auto _ : state) {
    codec.decode(set, coded.payloads[i++ % coded.payloads.size()], &depth);
    benchmark::DoNotOptimize(depth.data());
  }
}

void Register(const DepthFrames& set, const std::vector<DepthCodecRow>& codecs) {
  std::vector<Coded> coded;
  for (const DepthCodecRow& codec : codecs) coded.push_back(EncodeAll(set, codec));
  double best_peer = 0.0;
  for (size_t i = 1; i < coded.size(); ++i) best_peer = std::max(best_peer, coded[i].to_1);
  for (size_t i = 0; i < codecs.size(); ++i) {
    const std::string name = set.name + "/" + codecs[i].name;
    const DepthCodecRow& codec = codecs[i];
    const double to_1 = coded[i].to_1;
    const double by_best_peer = i == 0 ? to_1 / best_peer : 0.0;
    benchmark::RegisterBenchmark(("encode/" + name).c_str(), [=, &set](benchmark::State& state) {
      Encode(state, set, codec);
      state.counters["to_1"] = to_1;
      if (by_best_peer > 0.0) state.counters["by_best_peer"] = by_best_peer;
    })->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(("decode/" + name).c_str(),
                                 [&set, codec, every = std::move(coded[i])](
                                     benchmark::State& state) { Decode(state, set, codec, every); })
        ->Unit(benchmark::kMillisecond);
  }
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  // The first, so that the command line has the last word.
  std::string least_time = "--benchmark_min_time=0.1";
  std::vector<char*> arguments(argv, argv + argc);
  arguments.insert(arguments.begin() + 1, least_time.data());
  argc = static_cast<int>(arguments.size());
  benchmark::Initialize(&argc, arguments.data());
  const std::vector<vantage::DepthFrames> sets = vantage::AllSets();
  const std::vector<vantage::DepthCodecRow> codecs = vantage::MakeDepthCodecs();
  for (const vantage::DepthFrames& set : sets) vantage::Register(set, codecs);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
