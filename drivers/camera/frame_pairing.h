#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace vantage {

/// Finds the color image that belongs to a depth image: the one nearest in time, at most half a
/// period of depth away. Color images are announced as they come and lie in slots that the caller
/// keeps, so that nothing is copied:
///
///   slots[pairing.Offer(color_us)] = color;               // What lay there is wanted no more.
///   ...
///   while (pairing.ShouldWait(depth_us) && /* there is time */) { /* read and offer */ }
///   if (const auto match = pairing.Take(depth_us)) Use(slots[match->slot], match->delay_us);
///
/// No image is taken twice, and none from before one that was taken. Stamps of both kinds are of
/// one clock; they may be any numbers.
class FramePairing {
 public:
  static constexpr int kNumSlots = 4;

  struct Options {
    int64_t depth_period_us = 33'333;  ///< us, > 0
    int64_t color_period_us = 33'333;  ///< us, > 0
    int64_t modulus_us = 0;  ///< us at which stamps wrap around; 0: at 2^64, that is never
  };

  struct Match {
    int slot = 0;
    int64_t delay_us = 0;  ///< us, by how much color is later than depth; wrapping is undone
  };

  explicit FramePairing(const Options& options) : options_(options) {}

  /// Announces a color image. One with the stamp of the last is taken for the same and replaces it;
  /// one from before the last means that the clock started anew, and the others are forgotten.
  /// @return the slot for it. The slot of the last match comes last, so that its image lives until
  ///     all others were replaced.
  int Offer(int64_t color_us);

  /// Whether a color image that is yet to come can be nearer to this depth image than those that
  /// came, if both streams keep their rates. False too for a color stream that is silent, or far
  /// behind, for some images by now: depth is not to wait for it.
  [[nodiscard]] bool ShouldWait(int64_t depth_us) const;

  /// The color image for this depth image, if one has come. Those too old for this one are
  /// forgotten: depth images are to come in their order.
  std::optional<Match> Take(int64_t depth_us);

 private:
  struct Slot {
    int64_t stamp_us = 0;
    bool waits = false;      // For its depth image.
    int64_t used_order = 0;  // When it was last given to an image or matched; the least is reused.
  };

  // a - b, on the circle of stamps.
  [[nodiscard]] int64_t Difference(int64_t a_us, int64_t b_us) const;
  // Of those that wait; nothing within half a period: -1.
  [[nodiscard]] int Nearest(int64_t depth_us) const;
  [[nodiscard]] int SlotToReuse() const;

  Options options_;
  std::array<Slot, kNumSlots> slots_{};
  int64_t order_ = 0;
  std::optional<int64_t> newest_us_;  // Stamp of the last color image.
  int num_depth_since_color_ = 0;     // Depth images since the last color image came.
};

}  // namespace vantage
