// The decoders in Python and Java give what the C++ encoder was given, and refuse what is damaged.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "common/depth_codec/crc32c.h"
#include "common/depth_codec/depth_encoder.h"
#include "common/format.h"
#include "tests/common/depth_codec/support/depth_images.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

struct Language {
  std::string name;
  std::string decoder;    ///< command; takes files
  std::string available;  ///< command that succeeds where the decoder can run
  std::string needs;
};

std::vector<Language> Languages() {
  const std::string jar = VANTAGE_DEPTH_CODEC_JAR;
  return {
      {"Python",
       "/usr/bin/python3 " VANTAGE_SOURCE_DIR "/common/depth_codec/python/vantage_depth_codec.py",
       "/usr/bin/python3 -c 'import numpy'",
       "python3-numpy"},
      {"Java",
       "java -XX:TieredStopAtLevel=1 -cp " + jar + " vantage.DepthCodec",
       "test -f '" + jar + "' && java -version",
       "default-jdk"}};
}

bool Runs(const std::string& command) { return std::system((command + " 2>&1").c_str()) == 0; }

class OtherLanguage : public testing::TestWithParam<Language> {
 protected:
  void SetUp() override {
    if (!Runs(GetParam().available + " >/dev/null")) {
      GTEST_SKIP() << GetParam().name << " can't run here: needs " << GetParam().needs;
    }
    folder_ = fs::temp_directory_path() /
              Format("depth_codec_%s_%d", GetParam().name.c_str(), static_cast<int>(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override {
    std::error_code ignored;
    if (!folder_.empty()) fs::remove_all(folder_, ignored);
  }

  std::string Write(const std::string& name, const std::vector<uint8_t>& payload) const {
    const std::string file = (folder_ / name).string();
    std::ofstream stream(file, std::ios::binary);
    for (const uint8_t byte : payload) stream.put(static_cast<char>(byte));
    return file;
  }

  static std::string Read(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }

  static std::string Pgm(const TestDepth& image) {
    std::string text = Format("P5\n%d %d\n65535\n", image.width, image.height);
    for (const uint16_t value : image.depth) {
      text.push_back(static_cast<char>(value >> 8U));
      text.push_back(static_cast<char>(value & 0xffU));
    }
    return text;
  }

  fs::path folder_;
};

TEST_P(OtherLanguage, DecodesWhatTheEncoderWrites) {
  Rng rng(1);
  std::vector<TestDepth> images = AdversarialDepths(rng);
  for (const double sigma : {0.3, 2.0, 400.0}) {
    images.push_back(StructuredLightDepth(640, 121, sigma, rng));
  }
  DepthEncoder encoder;
  std::string command = GetParam().decoder;
  std::vector<std::string> files;
  for (const TestDepth& image : images) {
    files.push_back(
        Write(Format("%zu", files.size()), encoder.Encode(image.width, image.height, image.depth)));
    command += " " + files.back();
  }
  ASSERT_TRUE(Runs(command));
  for (size_t i = 0; i < images.size(); ++i) {
    EXPECT_TRUE(Read(files[i] + ".pgm") == Pgm(images[i])) << images[i].name;
  }
}

TEST_P(OtherLanguage, RefusesDamage) {
  Rng rng(2);
  const std::vector<uint8_t> sound =
      DepthEncoder().Encode(100, 30, StructuredLightDepth(100, 30, 0.5, rng).depth);
  std::string command = GetParam().decoder;
  std::vector<std::string> files;
  const auto add = [&](std::vector<uint8_t> payload, bool mend) {
    if (mend && payload.size() > 8) {
      const uint32_t checksum = Crc32c(std::span(payload).subspan(8));
      for (size_t i = 0; i < 4; ++i) payload[4 + i] = static_cast<uint8_t>(checksum >> (8 * i));
    }
    files.push_back(Write(Format("%zu", files.size()), payload));
    command += " " + files.back();
  };
  for (size_t i = 0; i < sound.size(); i += 37) {
    std::vector<uint8_t> payload = sound;
    payload[i] = static_cast<uint8_t>(payload[i] ^ 0x10);
    add(payload, false);
    add({sound.begin(), sound.begin() + static_cast<std::ptrdiff_t>(i)}, true);
  }
  const size_t certain = files.size();
  for (size_t i = 8; i < sound.size(); i += 29) {
    std::vector<uint8_t> payload = sound;
    payload[i] = static_cast<uint8_t>(payload[i] ^ 0x40);
    add(payload, true);
  }
  const std::string said = (folder_ / "said").string();
  EXPECT_FALSE(Runs("{ " + command + "; } >" + said));
  for (size_t i = 0; i < certain; ++i) EXPECT_FALSE(fs::exists(files[i] + ".pgm")) << i;
  // A sentence for each that was refused, and no trace of a program that failed.
  const std::string text = Read(said);
  for (const std::string& file : files) {
    EXPECT_EQ(fs::exists(file + ".pgm"), text.find(file + ": ") == std::string::npos) << file;
  }
  EXPECT_EQ(text.find("Traceback"), std::string::npos) << text;
  EXPECT_EQ(text.find("Exception in"), std::string::npos) << text;
}

INSTANTIATE_TEST_SUITE_P(In,
                         OtherLanguage,
                         testing::ValuesIn(Languages()),
                         [](const auto& language) { return language.param.name; });

}  // namespace
}  // namespace vantage
