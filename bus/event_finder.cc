#include "bus/event_finder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <tuple>

#include "bus/message_check.h"
#include "bus/message_schema.h"

namespace vantage {
namespace {

constexpr auto kHeader = static_cast<int64_t>(EventHeader::kBytes);
constexpr int64_t kScanBytes = 1 << 16;   // at a time
constexpr int64_t kPeekCost = 512;        // bytes of looking ahead that a far header counts as
constexpr int64_t kRivalReach = 1 << 16;  // bytes

bool IsPrintable(std::string_view text) {
  return std::ranges::all_of(text, [](char letter) { return letter >= ' ' && letter <= '~'; });
}

int BitsOff(uint32_t sync) { return std::popcount(sync ^ EventHeader::kSync); }

// A count that goes on from `last`, perhaps after a gap.
bool Follows(int64_t number, int64_t last) {
  constexpr int64_t kLargestGap = 1'000'000;
  return last >= 0 && number > last && number - last <= kLargestGap;
}

}  // namespace

std::optional<EventFinder::Found> EventFinder::EventAt(int64_t offset,
                                                       std::optional<int64_t> last_number) {
  const std::optional<EventHeader> header = HeaderAt(offset);
  if (!header) return {};
  const int64_t end = offset + (header->HasPlausibleLengths() ? header->EventBytes() : 0);
  const bool whole = end > offset && end <= window_.size();
  // The event, the header behind it and where else one may be, at once.
  const std::span<const std::byte> around =
      whole ? window_.At(offset, end - offset + kRivalReach + kHeader)
            : std::span<const std::byte>();
  const Link link = whole ? LinkAt(end, header->number) : Link::kNone;
  const bool in_sequence = !last_number || header->number == *last_number + 1;
  const auto next_number = [&](int64_t at) -> std::optional<int64_t> {
    const std::optional<EventHeader> next = HeaderAt(at);
    return next && BitsOff(next->sync) <= 1 ? std::optional(next->number) : std::nullopt;
  };
  if (header->sync != EventHeader::kSync) {
    const bool surrounded = last_number && in_sequence && link == Link::kCounts;
    if (!surrounded && (BitsOff(header->sync) > 1 || link == Link::kNone)) return {};
    Found found{.header = *header, .mended = "damaged sync", .next_number = next_number(end)};
    found.header.sync = EventHeader::kSync;
    return found;
  }
  if (link == Link::kCounts && !(HasRival(around, *header) && IsOutrivaled(offset, *header))) {
    return Found{.header = *header, .mended = nullptr, .next_number = header->number + 1};
  }
  // Either the numbers here do not count, or the lengths lead to a wrong place.
  const bool is_sound = whole && IsSoundMessage(offset, *header) == true;
  if (!is_sound && (link == Link::kNone || in_sequence)) {
    const std::optional<EventHeader> mended = MendLengths(offset, *header, link);
    if (mended && !(link == Link::kHeader && GoesOnBehind(end, offset + mended->EventBytes()))) {
      return Found{.header = *mended,
                   .mended = "damaged length",
                   .next_number = next_number(offset + mended->EventBytes())};
    }
  }
  if (link != Link::kNone) {
    return Found{.header = *header, .mended = nullptr, .next_number = next_number(end)};
  }
  // Nothing follows: what is there is the damaged part, unless events lie inside.
  if (!whole || HasSuccessorInside(offset, *header)) return {};
  return Found{.header = *header, .mended = nullptr, .next_number = {}};
}

int64_t EventFinder::FindEvent(int64_t begin,
                               std::optional<int64_t> last_number,
                               bool only_successors) {
  const int64_t size = window_.size();
  int64_t counting = size;
  int64_t plausible = size;
  for (int64_t at = FindHeader(begin, size); at < size; at = FindHeader(at + 1, size)) {
    const std::optional<EventHeader> header = HeaderAt(at);
    if (!header) break;
    const Link link = LinkAt(at + header->EventBytes(), header->number);
    if (last_number && Follows(header->number, *last_number)) {
      const bool is_near = header->number - *last_number <= 1000;
      if (link != Link::kNone || (is_near && ChannelScore(at, *header) > 64)) {
        // What leads here number by number belongs to it: the last number was none of this log.
        return counting < at && FollowCount(counting, at) == at ? counting : at;
      }
    }
    if (link == Link::kCounts) counting = std::min(counting, at);
    plausible = std::min(plausible, at);
    const bool knows_no_better = !last_number && link == Link::kCounts;
    lookahead_ -= kPeekCost;
    if (knows_no_better || lookahead_ <= 0) break;
  }
  if (only_successors && lookahead_ > 0) return size;
  return counting < size ? counting : plausible;
}

int64_t EventFinder::FindChain(int64_t begin, int64_t end, int64_t min_number) {
  const int64_t lookahead = lookahead_;
  int64_t at = FindHeader(begin, end);
  while (at < end) {
    const std::optional<EventHeader> header = HeaderAt(at);
    if (header && header->number >= min_number && !ChainAt(at).empty()) break;
    at = FindHeader(at + 1, end);
  }
  lookahead_ = lookahead;
  return at;
}

std::optional<EventHeader> EventFinder::TypicalHeader(int64_t place) {
  std::vector<EventHeader> chain = ChainAt(place);
  if (chain.empty()) return {};
  const auto median = chain.begin() + static_cast<std::ptrdiff_t>((chain.size() - 1) / 2);
  std::ranges::nth_element(chain, median, {}, &EventHeader::utime);
  return *median;
}

// Headers that lead to each other, three or up to the file's end; none where they lead nowhere.
std::vector<EventHeader> EventFinder::ChainAt(int64_t place) {
  constexpr size_t kLength = 3;
  std::vector<EventHeader> chain;
  while (chain.size() < kLength && place < window_.size()) {
    const std::optional<EventHeader> header = HeaderAt(place);
    if (!header || !header->IsPlausible()) return {};
    chain.push_back(*header);
    place += header->EventBytes();
  }
  return chain;
}

void EventFinder::Learn(const EventHeader& header, std::string_view channel) {
  lookahead_ += header.EventBytes();
  if (channels_.size() < kMaxChannels && !channels_.contains(channel)) channels_.emplace(channel);
}

bool EventFinder::LooksLikeSync(int64_t offset) {
  std::array<std::byte, 4> bytes{};
  std::array<std::byte, 4> sync{};
  StoreBigEndian(EventHeader::kSync, std::span(sync));
  const auto count = static_cast<size_t>(std::clamp<int64_t>(window_.size() - offset, 0, 4));
  if (!window_.Peek(offset, std::span(bytes).first(count))) return false;
  std::copy(sync.begin() + static_cast<std::ptrdiff_t>(count),
            sync.end(),
            bytes.begin() + static_cast<std::ptrdiff_t>(count));
  return BitsOff(LoadBigEndian<uint32_t>(bytes)) <= 1;
}

std::optional<EventHeader> EventFinder::HeaderAt(int64_t offset) {
  std::array<std::byte, EventHeader::kBytes> bytes{};
  if (!window_.Peek(offset, bytes)) return {};
  return EventHeader::Load(bytes);
}

EventFinder::Link EventFinder::LinkAt(int64_t end, int64_t number) {
  if (end == window_.size()) return Link::kEnd;
  if (end > window_.size()) return Link::kNone;
  const std::optional<EventHeader> next = HeaderAt(end);
  if (!next) return LooksLikeSync(end) ? Link::kHeader : Link::kNone;
  const bool counts = number < std::numeric_limits<int64_t>::max() && next->number == number + 1;
  if (counts && BitsOff(next->sync) <= 1) return Link::kCounts;
  return next->IsPlausible() ? Link::kHeader : Link::kNone;
}

// A quick look for another header with the next number where one would be if a bit of a length were
// flipped. @param around the event and what is behind it.
bool EventFinder::HasRival(std::span<const std::byte> around, const EventHeader& header) {
  const int64_t end = header.EventBytes();
  const int64_t last = static_cast<int64_t>(around.size()) - kHeader;
  for (int64_t step = 1; step <= kRivalReach; step *= 2) {
    for (const int64_t at : {end - step, end + step}) {
      if (at < kHeader || at > last) continue;
      if (around[static_cast<size_t>(at)] != std::byte{EventHeader::kSync >> 24U}) continue;
      const auto rival = EventHeader::Load(around.subspan(static_cast<size_t>(at)));
      if (rival.IsPlausible() && rival.number == header.number + 1) return true;
    }
  }
  return false;
}

// Of two places that the next number is at, the log goes on longer from the right one.
bool EventFinder::IsOutrivaled(int64_t offset, const EventHeader& header) {
  if (IsSoundMessage(offset, header) == true) return false;
  const std::optional<EventHeader> mended = MendLengths(offset, header, Link::kHeader);
  if (!mended) return false;
  const int64_t size = window_.size();
  return FollowCount(offset + mended->EventBytes(), size) >
         std::max(FollowCount(offset + header.EventBytes(), size), offset + mended->EventBytes());
}

// Whether it is the number of the header at `end` that is wrong: the log goes on behind it, and
// what counts up from the other place does not come past it.
bool EventFinder::GoesOnBehind(int64_t end, int64_t counted) {
  const int64_t size = window_.size();
  const int64_t reach = FollowCount(counted, size);
  const bool was_followed_to_its_end = FollowCount(reach, size) == reach;
  if (reach > end || !was_followed_to_its_end) return false;
  const std::optional<EventHeader> next = HeaderAt(end);
  if (!next) return false;
  const int64_t behind = end + next->EventBytes();
  return FollowCount(behind, size) > behind;
}

// Goes from header to header as long as numbers count up, at most to `end` and not for long.
// @return how far it came.
int64_t EventFinder::FollowCount(int64_t begin, int64_t end) {
  constexpr int kMost = 100;
  int64_t at = begin;
  for (int i = 0; i < kMost && at < end; ++i) {
    const std::optional<EventHeader> header = HeaderAt(at);
    if (!header || !header->HasPlausibleLengths()) break;
    const int64_t next = at + header->EventBytes();
    const Link link = LinkAt(next, header->number);
    if (link != Link::kCounts && !(link == Link::kEnd && next == end)) break;
    at = next;
  }
  lookahead_ -= kPeekCost;
  return at;
}

// Lengths of which one bit was flipped: those with which the next event comes right behind.
std::optional<EventHeader> EventFinder::MendLengths(int64_t offset,
                                                    const EventHeader& header,
                                                    Link link) {
  std::optional<EventHeader> best;
  // Whether numbers count on, how far from there, how likely the channel is; of those that come to
  // the same, the first end: a log inside of a message lies inside of it with all of its events.
  std::tuple<bool, int64_t, int, int64_t> best_score;
  lookahead_ -= 64 * kPeekCost;
  for (unsigned bit = 0; bit < 64 && lookahead_ > 0; ++bit) {
    EventHeader mended = header;
    int32_t& length = bit < 32 ? mended.channel_bytes : mended.data_bytes;
    length = static_cast<int32_t>(static_cast<uint32_t>(length) ^ (1U << (bit % 32)));
    if (!mended.HasPlausibleLengths()) continue;
    const int64_t end = offset + mended.EventBytes();
    const Link mended_link = LinkAt(end, header.number);
    const bool counts = mended_link == Link::kCounts;
    if (mended_link == Link::kNone || (!counts && link != Link::kNone)) continue;
    if (mended_link == Link::kEnd && !EndsWell(offset, header, mended)) continue;
    const std::tuple score(
        counts, counts ? FollowCount(end, window_.size()) : 0, ChannelScore(offset, mended), -end);
    if (!best || score > best_score) {
      best = mended;
      best_score = score;
    }
  }
  return best;
}

// Of lengths with which an event would be the file's last. A file that was cut off may end there
// by chance.
bool EventFinder::EndsWell(int64_t offset, const EventHeader& read, const EventHeader& mended) {
  const bool was_shortened = read.HasPlausibleLengths() && read.EventBytes() < mended.EventBytes();
  if (was_shortened && LooksLikeSync(offset + read.EventBytes())) return false;
  return IsSoundMessage(offset, mended).value_or(was_shortened);
}

// Whether the data are a message of the type that they name; nothing when it is none of ours.
std::optional<bool> EventFinder::IsSoundMessage(int64_t offset, const EventHeader& header) {
  const std::span<const std::byte> event = window_.At(offset, header.EventBytes());
  const size_t begin = EventHeader::kBytes + static_cast<size_t>(header.channel_bytes);
  if (event.size() < begin + sizeof(int64_t)) return {};
  const MessageSchema* schema = FindSchema(LoadBigEndian<int64_t>(event.subspan(begin)));
  if (schema == nullptr) return {};
  return CheckMessageBytes(std::string(schema->name), event.subspan(begin)).ok();
}

// Higher for channels that are likelier: known ones before, else the longest that can be read: what
// follows a channel is a fingerprint.
int EventFinder::ChannelScore(int64_t offset, const EventHeader& header) {
  std::array<char, kMaxChannelName> letters{};
  const auto size = static_cast<size_t>(header.channel_bytes);
  if (!window_.Peek(offset + kHeader, std::as_writable_bytes(std::span(letters).first(size)))) {
    return 0;
  }
  const std::string_view channel(letters.data(), size);
  if (channels_.contains(channel)) return 100;
  return IsPrintable(channel) ? static_cast<int>(size) : 0;
}

bool EventFinder::HasSuccessorInside(int64_t offset, const EventHeader& header) {
  const int64_t end = offset + header.EventBytes();
  for (int64_t at = FindHeader(offset + 1, end); at < end; at = FindHeader(at + 1, end)) {
    if (lookahead_ <= 0) return true;
    lookahead_ -= kPeekCost;
    const std::optional<EventHeader> inside = HeaderAt(at);
    if (inside && Follows(inside->number, header.number) &&
        LinkAt(at + inside->EventBytes(), inside->number) != Link::kNone) {
      return true;
    }
  }
  return false;
}

// The first plausible header that begins in [begin, end); end when there is none.
int64_t EventFinder::FindHeader(int64_t begin, int64_t end) {
  constexpr int kFirst = EventHeader::kSync >> 24U;
  for (int64_t at = begin; at < end; at += kScanBytes) {
    const std::span<const std::byte> bytes = window_.At(at, kScanBytes + kHeader - 1);
    const int64_t last =
        std::min({kScanBytes, end - at, static_cast<int64_t>(bytes.size()) - kHeader + 1});
    int64_t i = 0;
    while (i < last) {
      const auto* from = bytes.data() + i;
      const auto* hit =
          static_cast<const std::byte*>(std::memchr(from, kFirst, static_cast<size_t>(last - i)));
      if (hit == nullptr) break;
      i = hit - bytes.data();
      if (EventHeader::Load(bytes.subspan(static_cast<size_t>(i))).IsPlausible()) {
        lookahead_ -= at + i - begin;
        return at + i;
      }
      ++i;
    }
    if (last < kScanBytes) break;
  }
  lookahead_ -= end - begin;
  return end;
}

}  // namespace vantage
