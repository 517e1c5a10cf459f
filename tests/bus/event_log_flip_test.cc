// One bit that flipped in a log costs one event at most, and the reader says which wherever it can
// see it; all others come as they were written.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "tests/bus/support/mixed_log.h"

namespace vantage {
namespace {

enum class Part { kSync, kNumber, kUtime, kChannelLength, kDataLength, kRest };

Part PartAt(size_t in_event) {
  constexpr std::array<size_t, 5> kEnds = {4, 12, 20, 24, 28};
  const auto* end = std::ranges::upper_bound(kEnds, in_event);
  return static_cast<Part>(end - kEnds.begin());
}

struct Outcome {
  int64_t flips = 0;
  int64_t lost = 0;    // of sync and lengths: the event did not come
  int64_t mended = 0;  // of these: it came all the same
};

class Flipper {
 public:
  explicit Flipper(MixedLog log) : log_(std::move(log)), file_(log_.bytes) {}

  [[nodiscard]] size_t num_bits() const { return 8 * log_.bytes.size(); }
  [[nodiscard]] const MixedLog& log() const { return log_; }
  [[nodiscard]] const std::map<Part, Outcome>& outcomes() const { return outcomes_; }

  void Flip(size_t bit) {
    const size_t byte = bit / 8;
    const auto event = static_cast<size_t>(std::ranges::upper_bound(log_.offsets, byte) -
                                           log_.offsets.begin() - 1);
    SCOPED_TRACE(testing::Message() << "bit " << bit % 8 << " of byte " << byte << ", in event "
                                    << event << " at its byte " << byte - log_.offsets[event]);
    file_.Put(byte, log_.bytes[byte] ^ static_cast<std::byte>(1U << (bit % 8)));
    const ReadBack read = ReadDamaged(file_.path(), log_);
    file_.Put(byte, log_.bytes[byte]);
    Judge(read, event, PartAt(byte - log_.offsets[event]));
  }

 private:
  void Judge(const ReadBack& read, size_t event, Part part) {
    ASSERT_LE(read.missing.size(), 1U);
    for (const size_t missing : read.missing) ASSERT_EQ(missing, event);
    ASSERT_LE(read.num_others, static_cast<int>(read.missing.size()));
    Outcome& outcome = outcomes_[part];
    ++outcome.flips;
    const bool is_frame =
        part == Part::kSync || part == Part::kChannelLength || part == Part::kDataLength;
    if (!is_frame) {
      // It comes, changed, and nothing else is touched.
      ASSERT_EQ(read.missing.size(), 1U);
      ASSERT_EQ(read.num_others, 1);
      ASSERT_FALSE(read.damage.any()) << read.damage.Describe();
      return;
    }
    ASSERT_EQ(read.damage.places.size(), 1U);
    const LogDamage::Place& place = read.damage.places[0];
    const auto number = static_cast<int64_t>(event);
    ASSERT_GE(place.offset, static_cast<int64_t>(log_.offsets[event]));
    ASSERT_LT(place.offset, static_cast<int64_t>(log_.offsets[event + 1]));
    if (place.num_events > 0) {
      ASSERT_EQ(place.first_number, number);
      ASSERT_EQ(place.num_events, 1);
    }
    outcome.lost += static_cast<int64_t>(read.missing.size());
    outcome.mended += read.missing.empty() ? 1 : 0;
  }

  MixedLog log_;
  MemoryFile file_;
  std::map<Part, Outcome> outcomes_;
};

TEST(EventLogFlip, EveryBitOfASmallLog) {
  Flipper flipper(MakeMixedLog(24, 5));
  for (size_t bit = 0; bit < flipper.num_bits(); ++bit) {
    flipper.Flip(bit);
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(EventLogFlip, AThousandEvents) {
  Flipper flipper(MakeMixedLog(1000, 1));
  for (size_t bit = 0; bit < flipper.num_bits(); bit += 997) {
    flipper.Flip(bit);
    if (testing::Test::HasFatalFailure()) return;
  }
  // Every header: bits of sync and lengths, one of each, and the low ones of the number, with which
  // it may fit another place.
  for (size_t event = 0; event < flipper.log().events.size(); ++event) {
    const size_t header = 8 * flipper.log().offsets[event];
    flipper.Flip(header + event % 32);
    flipper.Flip(header + 160 + (7 * event) % 64);
    for (size_t bit = 0; bit < 3; ++bit) flipper.Flip(header + 88 + bit);
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(EventLogFlip, EveryBitOfAThousandEvents) {
  if (std::getenv("VANTAGE_EVERY_FLIP") == nullptr) {
    GTEST_SKIP() << "takes two minutes, more than a test may: set VANTAGE_EVERY_FLIP=1";
  }
  Flipper flipper(MakeMixedLog(1000, 1));
  for (size_t bit = 0; bit < flipper.num_bits(); ++bit) {
    flipper.Flip(bit);
    if (testing::Test::HasFatalFailure()) return;
  }
  for (const auto& [part, outcome] : flipper.outcomes()) {
    std::printf("part %d: %jd flips, %jd mended, %jd lost\n",
                static_cast<int>(part),
                intmax_t{outcome.flips},
                intmax_t{outcome.mended},
                intmax_t{outcome.lost});
  }
}

}  // namespace
}  // namespace vantage
