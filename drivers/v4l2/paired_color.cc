#include "drivers/v4l2/paired_color.h"

#include <algorithm>
#include <utility>

namespace vantage {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr int kMostErrors = 3;  // one after the other, before the device counts as broken

FramePairing::Options PairingOf(int fps) {
  FramePairing::Options options;
  options.depth_period_us = options.color_period_us = 1'000'000 / fps;
  return options;
}

}  // namespace

Result<std::unique_ptr<PairedColor>> PairedColor::Start(const std::string& path,
                                                        const StreamRequest& request) {
  Result<std::unique_ptr<V4l2Stream>> stream = V4l2Stream::Open(path);
  if (!stream) return stream.error();
  const Result<void> started = (*stream)->Start(request, "auto", V4l2Stream::Kind::kColor);
  if (!started) return started.error();
  return std::unique_ptr<PairedColor>(new PairedColor(std::move(*stream), request));
}

PairedColor::PairedColor(std::unique_ptr<V4l2Stream> stream, const StreamRequest& request)
    : stream_(std::move(stream)),
      period_(1'000'000 / request.fps),
      pairing_(PairingOf(request.fps)) {
  for (int i = 0; i <= FramePairing::kNumSlots; ++i) {
    slots_.push_back({FrameConverter(stream_->format(), request.color_layout, {}), {}, {}});
  }
}

std::optional<RawImage> PairedColor::Find(int64_t depth_us) {
  // What came meanwhile.
  for (int i = 0; i < FramePairing::kNumSlots && ReadOne(milliseconds(0)); ++i) {
  }
  const auto deadline = steady_clock::now() + period_;
  while (!is_gone_ && pairing_.ShouldWait(depth_us)) {
    const auto left = std::chrono::ceil<milliseconds>(deadline - steady_clock::now());
    if (left.count() <= 0) break;
    ReadOne(left);
  }
  const std::optional<FramePairing::Match> match = pairing_.Take(depth_us);
  if (!match) return std::nullopt;
  return slots_[static_cast<size_t>(match->slot)].image;
}

bool PairedColor::ReadOne(milliseconds timeout) {
  CapturedBuffer captured;
  switch (stream_->Read(timeout, &captured)) {
    case CaptureQueue::Outcome::kTimeout:
      return false;
    case CaptureQueue::Outcome::kGone:
      is_gone_ = true;
      return false;
    case CaptureQueue::Outcome::kError:
      is_gone_ = ++num_errors_ > kMostErrors;
      return !is_gone_;
    case CaptureQueue::Outcome::kFilled:
      break;
  }
  num_errors_ = 0;
  if (!captured.fault.empty()) return true;
  // Into the spare one, so that a bad image takes the place of none.
  Slot& spare = slots_.back();
  if (!spare.converter.Convert(captured.data, &spare.image).empty()) return true;
  const std::byte* end = captured.data.data() + captured.data.size();
  if (spare.image.data.data() >= captured.data.data() && spare.image.data.data() < end) {
    spare.copy.assign(spare.image.data.begin(), spare.image.data.end());
    spare.image.data = spare.copy;
  }
  spare.image.device_time_us = captured.time_us;
  std::swap(spare, slots_[static_cast<size_t>(pairing_.Offer(captured.time_us))]);
  return true;
}

}  // namespace vantage
