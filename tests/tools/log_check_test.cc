// `vantage-log check` names the event in which a bit flipped, wherever that can be known.

#include "tools/log/log_check.h"

#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <optional>
#include <vector>

#include "bus/conversions.h"
#include "bus/event_log.h"
#include "bus/event_log_format.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "common/rng.h"
#include "perception/model/file_bytes.h"
#include "tests/tools/run_program.h"
#include "vantage/arm_status_t.hpp"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kStart = 1'700'000'000'000'000;  // us
constexpr int64_t kStep = 1 << 14;                 // us

struct LogCheckTest : ScratchTest {
  // Poses, states and depth images in turn, kStep apart.
  void SetUp() override {
    ScratchTest::SetUp();
    Rng rng(1);
    for (int64_t i = 0; i < 60; ++i) {
      const int64_t utime = kStart + kStep * i;
      offsets.push_back(Size());
      if (i % 3 == 0) {
        Pose pose = Pose::Identity();
        pose.linear() = rng.Rotation().toRotationMatrix();
        Write("CAMERA_A_TO_WORLD", utime, Encode(PoseToMessage(pose, utime)));
      } else if (i % 3 == 1) {
        arm_status_t status{};
        status.utime = utime;
        status.seq = i / 3;
        status.name = "A";
        Write("ARM_STATUS", utime, Encode(status));
      } else {
        std::vector<uint16_t> depth(24 * 18);
        for (uint16_t& each : depth) each = static_cast<uint16_t>(700 + rng.Below(20));
        const DepthCompression how = i % 2 == 0 ? DepthCompression::kVdc : DepthCompression::kZlib;
        Write("CAMERA_A", utime, Encode(DepthToMessage(24, 18, depth, utime, i / 3, "S", how)));
      }
    }
    offsets.push_back(Size());
    Store(bytes);
  }

  [[nodiscard]] fs::path log() const { return scratch() / "a.lcm"; }
  [[nodiscard]] size_t Size() const { return bytes.size(); }

  void Write(const std::string& channel, int64_t utime, const std::vector<std::byte>& data) {
    const size_t at = bytes.size();
    bytes.resize(at + EventHeader::kBytes);
    EventHeader{.number = static_cast<int64_t>(offsets.size()) - 1,
                .utime = utime,
                .channel_bytes = static_cast<int32_t>(channel.size()),
                .data_bytes = static_cast<int32_t>(data.size())}
        .Store(std::span(bytes).subspan(at));
    for (const char letter : channel) bytes.push_back(static_cast<std::byte>(letter));
    bytes.insert(bytes.end(), data.begin(), data.end());
  }

  void Store(const std::vector<std::byte>& all) const {
    std::ofstream(log(), std::ios::binary)
        .write(reinterpret_cast<const char*>(all.data()), static_cast<std::streamsize>(all.size()));
  }

  // Of the log with one bit flipped, or none.
  LogCheck Check(std::optional<size_t> bit) const {
    std::vector<std::byte> damaged = bytes;
    if (bit) damaged[*bit / 8] ^= static_cast<std::byte>(1U << (*bit % 8));
    Store(damaged);
    auto reader = std::move(EventLogReader::Open(log())).value();
    LogCheck check;
    while (const std::optional<LogEventView> event = reader->NextView()) check.Add(*event);
    check.Finish();
    return check;
  }

  // True when the event and no other is doubted.
  [[nodiscard]] bool Names(size_t event, size_t bit) const {
    const LogCheck check = Check(bit);
    bool named = check.num_doubts() > 0;
    for (const LogCheck::Doubt& doubt : check.doubts()) {
      named = named && doubt.place.offset == static_cast<int64_t>(offsets[event]);
    }
    return named;
  }

  std::vector<std::byte> bytes;
  std::vector<size_t> offsets;
};

TEST_F(LogCheckTest, DoubtsNothingInASoundLog) {
  const LogCheck check = Check({});
  EXPECT_EQ(check.num_events(), 60);
  EXPECT_EQ(check.num_doubts(), 0) << check.doubts()[0].reason;
  EXPECT_EQ(check.num_jumps(), 0);
}

TEST_F(LogCheckTest, EveryBitOfAnEventNumber) {
  for (const size_t event : {0U, 1U, 20U, 58U, 59U}) {
    for (size_t bit = 0; bit < 64; ++bit) {
      EXPECT_TRUE(Names(event, 8 * (offsets[event] + 4) + bit)) << event << ", bit " << bit;
    }
  }
}

// Those that lead away from the neighbors, which are 2^14 us away.
TEST_F(LogCheckTest, BitsOfAUtimeThatLeadFarAway) {
  for (size_t bit = 0; bit < 64; ++bit) {
    const size_t place = 63 - bit;  // In big-endian order, from the highest bit of the first byte.
    const size_t at = 8 * (offsets[20] + 12) + 8 * (place / 8) + (7 - place % 8);
    EXPECT_EQ(Names(20, at), bit > 14) << "bit of 2^" << bit;
  }
}

TEST_F(LogCheckTest, EveryBitOfAChannel) {
  for (const size_t event : {0U, 1U, 20U, 59U}) {
    const size_t length = event % 3 == 0 ? 17 : event % 3 == 1 ? 10 : 8;
    for (size_t bit = 0; bit < 8 * length; ++bit) {
      EXPECT_TRUE(Names(event, 8 * (offsets[event] + EventHeader::kBytes) + bit)) << bit;
    }
  }
}

TEST_F(LogCheckTest, EveryBitOfAFingerprint) {
  for (size_t bit = 0; bit < 64; ++bit) {
    EXPECT_TRUE(Names(20, 8 * (offsets[20] + EventHeader::kBytes + 8) + bit)) << bit;
    EXPECT_TRUE(Names(21, 8 * (offsets[21] + EventHeader::kBytes + 17) + bit)) << bit;
  }
}

TEST_F(LogCheckTest, BitsOfASeq) {
  const size_t seq = offsets[22] + EventHeader::kBytes + 10 + 16;
  for (size_t bit = 0; bit < 64; ++bit) EXPECT_TRUE(Names(22, 8 * seq + bit)) << bit;
}

// Compressed depth has a checksum: in the last bytes of the stream, and all before.
TEST_F(LogCheckTest, BitsOfCompressedDepth) {
  for (const size_t event : {20U, 23U}) {
    const size_t data = offsets[event] + EventHeader::kBytes + 8;
    const size_t stream = data + 8 + 8 + 4 + 2 + 8 + 16 + 4;
    const size_t end = offsets[event + 1] - 60;  // Metadata follow.
    ASSERT_GT(end, stream + 100);
    for (size_t byte = stream + 40; byte < end; byte += 7) {
      EXPECT_TRUE(Names(event, 8 * byte + byte % 8)) << byte - stream;
    }
  }
}

// Logs that were cut, filtered with their numbers kept, or put together are no damaged ones.
TEST_F(LogCheckTest, GapsAndNewBeginningsAreNoDoubts) {
  const auto part = [this](size_t begin, size_t end) {
    return std::vector<std::byte>(bytes.begin() + static_cast<std::ptrdiff_t>(offsets[begin]),
                                  bytes.begin() + static_cast<std::ptrdiff_t>(offsets[end]));
  };
  std::vector<std::byte> joined = part(0, 20);
  for (const auto& each : {part(30, 50), part(51, 60)}) {
    joined.insert(joined.end(), each.begin(), each.end());
  }
  bytes = joined;
  const LogCheck check = Check({});
  EXPECT_EQ(check.num_events(), 49);
  EXPECT_EQ(check.num_doubts(), 0) << check.doubts()[0].reason;
  EXPECT_EQ(check.num_jumps(), 2);
}

}  // namespace
}  // namespace vantage
