#include "tools/support/log_comparison.h"

#include <algorithm>
#include <compare>
#include <cstdlib>
#include <deque>
#include <functional>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "bus/channel_pattern.h"
#include "bus/event_log.h"
#include "bus/message_fields.h"

namespace vantage {
namespace {

// Messages that wait for their match, of one channel and log.
constexpr size_t kMostWaiting = 4096;
constexpr size_t kMostWaitingBytes = 32U << 20U;
// Of the second log, behind the last match.
constexpr size_t kLongestTail = 1000;

// By what messages find each other.
struct Key {
  int64_t time = 0;  // utime; seq where there is none
  int64_t instance = 0;
  auto operator<=>(const Key&) const = default;
};

struct Waiting {
  LogEvent event;
  Key key;
  int64_t utime = 0;
  int64_t seq = 0;
  bool has_seq = false;
};

Waiting WithKey(LogEvent event) {
  Waiting waiting;
  if (Result<MessageFields> fields = MessageFields::Open(event.data)) {
    using Event = MessageFields::Event;
    for (Event each = fields->Next();
         each != Event::kEnd && each != Event::kBeginArray && each != Event::kBeginStruct;
         each = fields->Next()) {
      if (each != Event::kNumbers || fields->field().is_array || fields->numbers().is_real()) {
        continue;
      }
      const int64_t value = fields->numbers().Integer(0);
      if (fields->field().name == "utime") waiting.utime = value;
      if (fields->field().name == "seq") waiting.seq = value;
      if (fields->field().name == "seq") waiting.has_seq = true;
      if (fields->field().name == "instance_id") waiting.key.instance = value;
    }
  }
  waiting.key.time = waiting.utime != 0 ? waiting.utime : waiting.seq;
  waiting.event = std::move(event);
  return waiting;
}

// The messages of one channel.
class Lane {
 public:
  Lane(ChannelComparison* result, const ComparisonTolerance& tolerance)
      : result_(result), tolerance_(tolerance) {}

  // @param other_ended the other log has no more messages.
  void Add(size_t side, Waiting message, bool other_ended) {
    ++result_->count.at(side);
    if (IsRepeat(side, message)) {
      ++result_->repeats.at(side);
      return;
    }
    std::deque<Waiting>& others = waiting_.at(1 - side);
    const auto match = std::ranges::find(others, message.key, &Waiting::key);
    if (match != others.end()) {
      side == 0 ? Compare(message, *match) : Compare(*match, message);
      const auto num_before = static_cast<size_t>(match - others.begin());
      bytes_.at(1 - side) -= match->event.data.size();
      others.erase(match);
      DropBefore(1 - side, message.key.time, num_before);
      DropBefore(side, message.key.time, waiting_.at(side).size());
      return;
    }
    if (other_ended) return Alone(side, message);
    bytes_.at(side) += message.event.data.size();
    waiting_.at(side).push_back(std::move(message));
    while (waiting_.at(side).size() > kMostWaiting || bytes_.at(side) > kMostWaitingBytes) {
      DropOldest(side);
    }
  }

  void DropAll(size_t side) {
    while (!waiting_.at(side).empty()) DropOldest(side);
  }

  // After all.
  void JudgeTail(int64_t end_of_first) {
    for (const auto& [utime, difference] : tail_) {
      if (std::abs(utime - end_of_first) <= kAnswerTime_us) {
        ++result_->late;
      } else {
        Note(difference);
      }
    }
  }

 private:
  bool IsRepeat(size_t side, const Waiting& message) {
    const size_t hash = std::hash<std::string_view>()(
        {reinterpret_cast<const char*>(message.event.data.data()), message.event.data.size()});
    const auto last = std::exchange(last_.at(side), {message.key, hash, true});
    return message.has_seq && last == last_.at(side);
  }

  void Compare(const Waiting& first, const Waiting& second) {
    const MessageComparison compared =
        CompareMessages(first.event.data, second.event.data, tolerance_);
    ++result_->matched;
    for (const auto& [utime, difference] : std::exchange(tail_, {})) Note(difference);
    if (compared.identical) ++result_->identical;
    if (compared.within) ++result_->within;
    result_->position_mm = std::max(result_->position_mm, compared.position_mm);
    result_->angle_deg = std::max(result_->angle_deg, compared.angle_deg);
    result_->number = std::max(result_->number, compared.number);
    if (compared.within) return;
    Note({first.event.channel,
          first.event.number,
          second.event.number,
          first.utime,
          first.seq,
          compared.beyond});
  }

  void Alone(size_t side, const Waiting& message) {
    EventDifference difference{
        message.event.channel, -1, -1, message.utime, message.seq, std::nullopt};
    (side == 0 ? difference.first_event : difference.second_event) = message.event.number;
    if (side == 0) return Note(difference);
    tail_.emplace_back(message.event.utime, difference);
    if (tail_.size() <= kLongestTail) return;
    Note(tail_.front().second);
    tail_.pop_front();
  }

  void Note(const EventDifference& difference) {
    const auto place = [](const EventDifference& each) {
      return std::tuple(each.utime, std::max(each.first_event, each.second_event));
    };
    if (!result_->first || place(difference) < place(*result_->first)) result_->first = difference;
  }

  // Those before a match can't find one any more, but for others of its time.
  void DropBefore(size_t side, int64_t time, size_t num_before) {
    for (; num_before > 0 && waiting_.at(side).front().key.time != time; --num_before) {
      DropOldest(side);
    }
  }

  void DropOldest(size_t side) {
    const Waiting& oldest = waiting_.at(side).front();
    Alone(side, oldest);
    bytes_.at(side) -= oldest.event.data.size();
    waiting_.at(side).pop_front();
  }

  ChannelComparison* result_;
  const ComparisonTolerance& tolerance_;
  std::array<std::deque<Waiting>, 2> waiting_;
  std::array<size_t, 2> bytes_{};
  std::array<std::tuple<Key, size_t, bool>, 2> last_{};
  std::deque<std::pair<int64_t, EventDifference>> tail_;  // With the events' utime, us.
};

// The messages of one log on the channels that are compared.
class Side {
 public:
  Side(std::unique_ptr<EventLogReader> reader, const ChannelPattern& channels)
      : reader_(std::move(reader)), channels_(channels) {}

  std::optional<LogEvent> Next() {
    while (std::optional<LogEvent> event = reader_->Next()) {
      last_utime_ = event->utime;
      if (channels_.Matches(event->channel)) return event;
    }
    ended_ = true;
    return std::nullopt;
  }
  [[nodiscard]] bool ended() const { return ended_; }
  /// us, of the last event that was read.
  [[nodiscard]] int64_t last_utime() const { return last_utime_; }
  [[nodiscard]] std::string damage() const {
    return reader_->damage().any() ? reader_->damage().Describe() : "";
  }

 private:
  std::unique_ptr<EventLogReader> reader_;
  const ChannelPattern& channels_;
  bool ended_ = false;
  int64_t last_utime_ = 0;
};

}  // namespace

bool ChannelComparison::clean() const {
  return within == matched && matched == count[0] - repeats[0] &&
         matched == count[1] - repeats[1] - late;
}

bool LogComparison::clean() const {
  return damage[0].empty() && damage[1].empty() &&
         std::ranges::all_of(channels, [](const auto& each) { return each.second.clean(); });
}

int64_t LogComparison::num_compared() const {
  int64_t number = 0;
  for (const auto& [name, channel] : channels) number += channel.count[0] + channel.count[1];
  return number;
}

const EventDifference* LogComparison::first() const {
  const EventDifference* earliest = nullptr;
  for (const auto& [name, channel] : channels) {
    if (!channel.first) continue;
    if (earliest == nullptr || channel.first->utime < earliest->utime) earliest = &*channel.first;
  }
  return earliest;
}

Result<LogComparison> CompareLogs(const std::filesystem::path& first,
                                  const std::filesystem::path& second,
                                  const std::string& channels,
                                  const ComparisonTolerance& tolerance) {
  const Result<ChannelPattern> pattern = ChannelPattern::Create(channels);
  if (!pattern) return pattern.error();
  std::vector<Side> sides;
  for (const std::filesystem::path& file : {first, second}) {
    Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(file);
    if (!reader) return reader.error();
    sides.emplace_back(std::move(reader).value(), *pattern);
  }
  LogComparison comparison;
  std::map<std::string, Lane> lanes;
  while (!sides[0].ended() || !sides[1].ended()) {
    for (const size_t side : {size_t{0}, size_t{1}}) {
      if (sides[side].ended()) continue;
      std::optional<LogEvent> event = sides[side].Next();
      if (!event) {
        for (auto& [channel, lane] : lanes) lane.DropAll(1 - side);
        continue;
      }
      const std::string channel = event->channel;
      Lane& lane =
          lanes.try_emplace(channel, &comparison.channels[channel], tolerance).first->second;
      lane.Add(side, WithKey(std::move(*event)), sides[1 - side].ended());
    }
  }
  for (const size_t side : {size_t{0}, size_t{1}}) {
    for (auto& [channel, lane] : lanes) lane.DropAll(side);
    comparison.damage.at(side) = sides[side].damage();
  }
  for (auto& [channel, lane] : lanes) lane.JudgeTail(sides[0].last_utime());
  return comparison;
}

}  // namespace vantage
