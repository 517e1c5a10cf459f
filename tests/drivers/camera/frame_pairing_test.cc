#include "drivers/camera/frame_pairing.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <optional>
#include <set>
#include <vector>

#include "common/rng.h"

namespace vantage {
namespace {

constexpr int64_t kPeriod = 33'333;
constexpr int64_t kHalf = kPeriod / 2;

/// Slots that remember which image lies in them, by its number.
class Pairs {
 public:
  explicit Pairs(const FramePairing::Options& options = {}) : pairing_(options) {}

  void Color(int64_t stamp_us, int number) {
    held_[static_cast<size_t>(pairing_.Offer(stamp_us))] = number;
  }
  /// The number of the color image; nothing: none.
  std::optional<int> Depth(int64_t stamp_us) {
    const std::optional<FramePairing::Match> match = pairing_.Take(stamp_us);
    if (!match) return std::nullopt;
    delay_us = match->delay_us;
    return held_[static_cast<size_t>(match->slot)];
  }
  [[nodiscard]] bool Waits(int64_t stamp_us) const { return pairing_.ShouldWait(stamp_us); }

  int64_t delay_us = 0;

 private:
  FramePairing pairing_;
  std::array<int, FramePairing::kNumSlots> held_{};
};

TEST(FramePairing, TakesTheNearestWithinHalfAPeriodAndTellsTheDelay) {
  Pairs pairs;
  pairs.Color(100'000, 1);
  pairs.Color(133'333, 2);
  EXPECT_EQ(pairs.Depth(130'000), 2);
  EXPECT_EQ(pairs.delay_us, 3'333);
  pairs.Color(166'666, 3);
  EXPECT_EQ(pairs.Depth(166'666 + kHalf), 3);
  EXPECT_EQ(pairs.delay_us, -kHalf);
}

TEST(FramePairing, NeverTakesAStaleOne) {
  Pairs pairs;
  pairs.Color(100'000, 1);
  EXPECT_EQ(pairs.Depth(100'000 + kHalf + 1), std::nullopt);
  // It was too old then and is for all that follow.
  EXPECT_EQ(pairs.Depth(100'000), std::nullopt);
  pairs.Color(200'000, 2);
  EXPECT_EQ(pairs.Depth(200'000 - kHalf - 1), std::nullopt);
  EXPECT_EQ(pairs.Depth(200'000 - kHalf), 2);
}

TEST(FramePairing, NeverTakesOneTwiceNorAnOlderOneAfterwards) {
  Pairs pairs;
  pairs.Color(100'000, 1);
  pairs.Color(110'000, 2);
  EXPECT_EQ(pairs.Depth(110'000), 2);
  EXPECT_EQ(pairs.Depth(110'000), std::nullopt);
  pairs.Color(110'000, 3);  // The same image again.
  EXPECT_EQ(pairs.Depth(110'000), std::nullopt);
}

TEST(FramePairing, TheSameStampAgainReplacesTheImageThatWaits) {
  Pairs pairs;
  pairs.Color(100'000, 1);
  pairs.Color(100'000, 2);
  EXPECT_EQ(pairs.Depth(100'000), 2);
  EXPECT_EQ(pairs.Depth(100'000), std::nullopt);
}

TEST(FramePairing, OfTwoEquallyFarTheFirst) {
  Pairs pairs;
  pairs.Color(100'000, 1);
  pairs.Color(120'000, 2);
  EXPECT_EQ(pairs.Depth(110'000), 1);
}

TEST(FramePairing, StampsOf32BitsWrapAround) {
  Pairs pairs({.modulus_us = int64_t{1} << 32});
  const int64_t wrap = int64_t{1} << 32;
  pairs.Color(wrap - 5'000, 1);
  EXPECT_EQ(pairs.Depth(5'000), 1);
  EXPECT_EQ(pairs.delay_us, -10'000);
  EXPECT_TRUE(pairs.Waits(30'000));
  pairs.Color(28'333, 2);
  EXPECT_EQ(pairs.Depth(30'000), 2);
  EXPECT_EQ(pairs.delay_us, -1'667);
}

TEST(FramePairing, AClockThatStartsAnewForgetsWhatWaits) {
  Pairs pairs;
  pairs.Color(50'000'000, 1);
  pairs.Color(0, 2);
  EXPECT_EQ(pairs.Depth(0), 2);
  EXPECT_EQ(pairs.Depth(50'000'000), std::nullopt);
}

TEST(FramePairing, AnyNumberIsAStamp) {
  constexpr int64_t kLeast = std::numeric_limits<int64_t>::min();
  constexpr int64_t kMost = std::numeric_limits<int64_t>::max();
  for (const int64_t modulus : {int64_t{0}, int64_t{1} << 32, int64_t{1}, kMost}) {
    Pairs pairs({.modulus_us = modulus});
    for (const int64_t color : {kLeast, kMost, int64_t{0}, int64_t{-1}, kLeast + 1}) {
      for (const int64_t depth : {kLeast, kMost, int64_t{0}, int64_t{-1}, kMost - 1}) {
        pairs.Color(color, 1);
        static_cast<void>(pairs.Waits(depth));
        const bool paired = pairs.Depth(depth).has_value();
        EXPECT_TRUE(!paired || std::abs(pairs.delay_us) <= kHalf) << pairs.delay_us;
      }
    }
  }
}

TEST(FramePairing, WaitsOnlyForWhatCanBeNearer) {
  Pairs pairs;
  EXPECT_TRUE(pairs.Waits(100'000));  // None yet.
  pairs.Color(100'000 - kPeriod, 1);
  EXPECT_TRUE(pairs.Waits(100'000));  // The next one will fit.
  pairs.Color(90'000, 2);
  EXPECT_FALSE(pairs.Waits(100'000));  // The next one is further.
  EXPECT_EQ(pairs.Depth(100'000), 2);
  pairs.Color(140'000, 3);
  EXPECT_FALSE(pairs.Waits(133'333));  // It came already.
}

TEST(FramePairing, WaitsForANearerOneOfAFasterStream) {
  Pairs pairs({.color_period_us = kPeriod / 2});
  pairs.Color(88'000, 1);
  EXPECT_TRUE(pairs.Waits(100'000));
  pairs.Color(104'666, 2);
  EXPECT_FALSE(pairs.Waits(100'000));
  EXPECT_EQ(pairs.Depth(100'000), 2);
}

TEST(FramePairing, DoesNotWaitForASlowerStreamsNextImage) {
  Pairs pairs({.color_period_us = 2 * kPeriod});
  pairs.Color(100'000, 1);
  EXPECT_EQ(pairs.Depth(100'000), 1);
  EXPECT_FALSE(pairs.Waits(100'000 + kPeriod));
  EXPECT_TRUE(pairs.Waits(100'000 + 2 * kPeriod));
}

TEST(FramePairing, ASilentStreamIsNotWaitedForLong) {
  Pairs pairs;
  int num_waits = 0;
  for (int64_t i = 0; i < 100; ++i) {
    if (pairs.Waits(i * kPeriod)) ++num_waits;
    EXPECT_EQ(pairs.Depth(i * kPeriod), std::nullopt);
  }
  EXPECT_LE(num_waits, 4);
  pairs.Color(100 * kPeriod, 1);
  EXPECT_TRUE(pairs.Waits(101 * kPeriod));
}

TEST(FramePairing, AStreamFarBehindIsNotWaitedFor) {
  Pairs pairs;
  for (int64_t i = 0; i < 100; ++i) {
    pairs.Color(i * kPeriod - 1'000'000, static_cast<int>(i));
    EXPECT_FALSE(pairs.Waits(i * kPeriod));
    EXPECT_EQ(pairs.Depth(i * kPeriod), std::nullopt);
  }
}

TEST(FramePairing, TheMatchedImageOutlivesAllOthers) {
  FramePairing pairing({});
  const int matched = pairing.Offer(0);
  ASSERT_EQ(pairing.Take(0)->slot, matched);
  std::set<int> others;
  for (int i = 1; i < FramePairing::kNumSlots; ++i) {
    others.insert(pairing.Offer(i * kPeriod));
  }
  EXPECT_EQ(others.size(), size_t{FramePairing::kNumSlots - 1});
  EXPECT_FALSE(others.contains(matched));
}

// Two streams with jitter and losses against a search through everything that had come.
TEST(FramePairing, AgreesWithASearchThroughAll) {
  Rng rng(7);
  for (int round = 0; round < 50; ++round) {
    const FramePairing::Options options{.depth_period_us = kPeriod,
                                        .color_period_us = round % 2 == 0 ? kPeriod : kPeriod / 2,
                                        .modulus_us = round % 3 == 0 ? 0 : int64_t{1} << 32};
    const auto stamp = [&](int64_t us) {
      return options.modulus_us == 0 ? us : us % options.modulus_us;
    };
    Pairs pairs(options);
    const int64_t start = (int64_t{1} << 32) - 500'000;
    std::vector<int64_t> came;  // By number.
    int last_taken = -1;
    int num_pairs = 0;
    int64_t color = start + static_cast<int64_t>(rng.Uniform(0.0, 30'000.0));
    for (int i = 0; i < 60; ++i) {
      const int64_t depth =
          start + i * kPeriod + static_cast<int64_t>(rng.Uniform(-3'000.0, 3'000.0));
      // Color comes up to this far after the depth image is there.
      const int64_t known_until = depth + static_cast<int64_t>(rng.Uniform(-10'000.0, 20'000.0));
      while (color < known_until) {
        if (rng.Uniform(0.0, 1.0) < 0.9) {
          pairs.Color(stamp(color), static_cast<int>(came.size()));
          came.push_back(color);
        }
        color += options.color_period_us + static_cast<int64_t>(rng.Uniform(-4'000.0, 4'000.0));
      }
      std::optional<int> expected;
      for (size_t k = static_cast<size_t>(last_taken + 1); k < came.size(); ++k) {
        const int64_t distance = std::abs(came[k] - depth);
        if (distance > kHalf) continue;
        if (expected && distance >= std::abs(came[static_cast<size_t>(*expected)] - depth)) {
          continue;
        }
        expected = static_cast<int>(k);
      }
      const std::optional<int> taken = pairs.Depth(stamp(depth));
      ASSERT_EQ(taken, expected) << "round " << round << " image " << i;
      if (!taken) continue;
      EXPECT_EQ(pairs.delay_us, came[static_cast<size_t>(*taken)] - depth);
      last_taken = *taken;
      ++num_pairs;
    }
    EXPECT_GT(num_pairs, 15);
  }
}

}  // namespace
}  // namespace vantage
