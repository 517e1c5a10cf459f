#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "common/rng.h"
#include "tests/tools/made_up_dataset.h"
#include "tests/tools/run_program.h"
#include "tools/evaluate/dataset_pcd.h"

namespace vantage {
namespace {

using made_up::Pcd;
using made_up::WriteText;

std::optional<std::string> Decompress(const std::vector<uint8_t>& bytes, size_t size) {
  return DecompressLzf(bytes, size);
}

TEST(DecompressLzf, LiteralsAndReferences) {
  EXPECT_EQ(Decompress({2, 'a', 'b', 'c'}, 3), "abc");
  // 3 bytes from 3 back.
  EXPECT_EQ(Decompress({2, 'a', 'b', 'c', 1U << 5U, 2}, 6), "abcabc");
  // 7 + 1 + 2 bytes from 1 back: it reads what it writes.
  EXPECT_EQ(Decompress({0, 'x', 7U << 5U, 1, 0}, 11), std::string(11, 'x'));
  EXPECT_EQ(Decompress({}, 0), "");
}

TEST(DecompressLzf, DamagedBytesGiveNothing) {
  EXPECT_FALSE(Decompress({2, 'a', 'b'}, 3));                 // Literals are missing.
  EXPECT_FALSE(Decompress({2, 'a', 'b', 'c'}, 4));            // Too few.
  EXPECT_FALSE(Decompress({2, 'a', 'b', 'c'}, 2));            // Too many.
  EXPECT_FALSE(Decompress({0, 'a', 1U << 5U, 1}, 4));         // Before the start.
  EXPECT_FALSE(Decompress({0, 'a', 1U << 5U}, 4));            // Half a reference.
  EXPECT_FALSE(Decompress({0, 'a', 7U << 5U}, 4));            // A third of a long one.
  EXPECT_FALSE(Decompress({0, 'a', 7U << 5U, 255, 0}, 100));  // Longer than what is left.
}

class PcdFile : public ScratchTest {
 protected:
  [[nodiscard]] Result<PointCloud> Read(const std::string& bytes) const {
    WriteText(scratch() / "cloud.pcd", bytes);
    return ReadPcd(scratch() / "cloud.pcd");
  }
  void ExpectRefused(const std::string& bytes, const std::string& part) const {
    const Result<PointCloud> read = Read(bytes);
    ASSERT_FALSE(read.ok());
    EXPECT_NE(read.error().message.find(part), std::string::npos) << read.error().message;
    EXPECT_NE(read.error().message.find("cloud.pcd"), std::string::npos) << read.error().message;
  }
  static std::string Replaced(const std::string& text,
                              const std::string& what,
                              const std::string& by) {
    std::string changed = text;
    const size_t at = changed.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return changed.replace(at, what.size(), by);
  }
};

TEST_F(PcdFile, BinaryAndCompressedHoldTheSamePoints) {
  Rng rng(1);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 12; ++i) points.push_back(rng.UnitVector().cast<float>());
  points[5].setConstant(std::numeric_limits<float>::quiet_NaN());
  for (const bool is_compressed : {false, true}) {
    const Result<PointCloud> cloud = Read(Pcd(points, 4, 3, is_compressed));
    ASSERT_TRUE(cloud.ok()) << cloud.error().message;
    EXPECT_EQ(cloud->width, 4);
    EXPECT_EQ(cloud->height, 3);
    ASSERT_EQ(cloud->points.size(), points.size());
    for (size_t i = 0; i < points.size(); ++i) {
      if (i == 5) {
        EXPECT_TRUE(cloud->points[i].array().isNaN().all());
      } else {
        EXPECT_EQ(cloud->points[i], points[i]);
      }
    }
  }
}

TEST_F(PcdFile, DamagedFilesAreOneSentence) {
  const std::vector<Eigen::Vector3f> points(6, Eigen::Vector3f::Ones());
  const std::string binary = Pcd(points, 3, 2, false);
  const std::string packed = Pcd(points, 3, 2, true);
  EXPECT_EQ(ReadPcd(scratch() / "absent.pcd").error().code, ErrorCode::kNotFound);
  ExpectRefused("", "no line \"DATA\"");
  ExpectRefused("no point cloud", "no line \"DATA\"");
  ExpectRefused(Replaced(binary, "DATA binary", "DATA ascii"), "expected binary");
  ExpectRefused(Replaced(binary, "FIELDS x y z rgba", "FIELDS x y w rgba"), "x, y and z");
  ExpectRefused(Replaced(binary, "TYPE F F F U", "TYPE F F U U"), "x, y and z");
  ExpectRefused(Replaced(binary, "SIZE 4 4 4 4", "SIZE 4 4 8 4"), "x, y and z");
  ExpectRefused(Replaced(binary, "SIZE 4 4 4 4", "SIZE 4 4 4 0"), "SIZE");
  ExpectRefused(Replaced(binary, "COUNT 1 1 1 1", "COUNT 1 1 1 99999"), "COUNT");
  ExpectRefused(Replaced(binary, "WIDTH 3", "WIDTH -3"), "WIDTH");
  ExpectRefused(Replaced(binary, "WIDTH 3", "WIDTH 99999999999999999999"), "WIDTH");
  ExpectRefused(Replaced(binary, "HEIGHT 2", "HEIGHT 16384000"), "HEIGHT");
  ExpectRefused(Replaced(binary, "POINTS 6", "POINTS 7"), "POINTS");
  ExpectRefused(binary.substr(0, binary.size() - 1), "95 bytes of points, expected 96");
  ExpectRefused(packed.substr(0, packed.size() - 1), "compressed bytes");
  ExpectRefused(packed.substr(0, packed.find("compressed\n") + 13), "ends before");
  std::string wrong = packed;
  wrong[wrong.find("compressed\n") + 11 + 8] = '\x1e';  // One literal fewer in the first run.
  ExpectRefused(wrong, "can't be decompressed");
}

}  // namespace
}  // namespace vantage
