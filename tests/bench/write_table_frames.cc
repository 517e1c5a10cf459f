// Writes VGA depth frames of the simulated sensor to a file, one after another, as little-endian
// 16-bit millimetres: what an emulated device shows.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <vector>

#include "tests/bench/table_frames.h"

int main(int argc, char** argv) {
  constexpr int kNumFrames = 16;
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_table_frames FILE\n");
    return 2;
  }
  std::ofstream file(argv[1], std::ios::binary);
  for (int number = 0; number < kNumFrames; ++number) {
    const vantage::TableFrame frame = vantage::MakeTableFrame(number);
    std::vector<char> bytes;
    for (const float depth : frame.depth.depth) {
      const auto millimetres =
          std::isnan(depth) ? uint16_t{0} : static_cast<uint16_t>(std::lround(1e3F * depth));
      bytes.push_back(static_cast<char>(millimetres & 0xffU));
      bytes.push_back(static_cast<char>(millimetres >> 8U));
    }
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }
  file.flush();
  if (file) return 0;
  std::fprintf(stderr, "write_table_frames: %s can't be written\n", argv[1]);
  return 2;
}
