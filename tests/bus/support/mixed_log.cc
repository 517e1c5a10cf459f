#include "tests/bus/support/mixed_log.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <memory>

#include "bus/event_log_format.h"
#include "bus/log_bus.h"
#include "bus/message_check.h"
#include "common/format.h"
#include "common/rng.h"
#include "vantage/arm_status_t.hpp"
#include "vantage/log_header_t.hpp"
#include "vantage/rigid_transform_t.hpp"

namespace vantage {
namespace {

using Bytes = std::vector<std::byte>;

constexpr int64_t kStart = 1'700'000'000'000'000;  // us

void Append(const LogEvent& event, Bytes* log) {
  const size_t at = log->size();
  log->resize(at + EventHeader::kBytes);
  EventHeader{.number = event.number,
              .utime = event.utime,
              .channel_bytes = static_cast<int32_t>(event.channel.size()),
              .data_bytes = static_cast<int32_t>(event.data.size())}
      .Store(std::span(*log).subspan(at));
  const auto channel = std::as_bytes(std::span(event.channel));
  log->insert(log->end(), channel.begin(), channel.end());
  log->insert(log->end(), event.data.begin(), event.data.end());
}

Bytes RandomBytes(size_t count, Rng& rng) {
  Bytes bytes(count);
  for (std::byte& each : bytes) each = static_cast<std::byte>(rng.Below(256));
  return bytes;
}

Bytes Pose(int64_t utime, Rng& rng) {
  rigid_transform_t pose{};
  pose.utime = utime;
  for (double& each : pose.trans) each = rng.Uniform(-1.0, 1.0);
  const Eigen::Quaterniond q = rng.Rotation();
  pose.quat[0] = q.w();
  pose.quat[1] = q.x();
  pose.quat[2] = q.y();
  pose.quat[3] = q.z();
  return Encode(pose);
}

Bytes Status(int64_t utime, int64_t seq) {
  arm_status_t status{};
  status.utime = utime;
  status.seq = seq;
  status.name = "XTION";
  return Encode(status);
}

Bytes Header() {
  log_header_t header{};
  header.utime = kStart;
  header.version = "1";
  FillSchemas(&header);
  return Encode(header);
}

// Foreign data with a log inside, whose first number is `number`; perhaps something around it.
Bytes LogInside(int64_t number, int64_t utime, Rng& rng) {
  Bytes bytes = RandomBytes(rng.Below(2) * 8, rng);
  const uint32_t count = 1 + rng.Below(4);
  for (uint32_t i = 0; i < count; ++i) {
    Append({.number = number + i,
            .utime = utime + i,
            .channel = rng.Below(2) == 0 ? "INSIDE" : "POSE",
            .data = RandomBytes(rng.Below(40), rng)},
           &bytes);
  }
  const Bytes rest = RandomBytes(rng.Below(3) * 5, rng);
  bytes.insert(bytes.end(), rest.begin(), rest.end());
  return bytes;
}

LogEvent MakeEvent(int64_t number, Rng& rng) {
  LogEvent event{.number = number, .utime = kStart + 1000 * number, .channel = "RAW", .data = {}};
  switch (number == 0 ? 99 : rng.Below(12)) {
    case 99:
      event.channel = "LOG_HEADER";
      event.data = Header();
      break;
    case 0:
    case 1:
    case 2:
      event.channel = "CAMERA_XTION_TO_WORLD";
      event.data = Pose(event.utime, rng);
      break;
    case 3:
    case 4:
      event.channel = "ARM_STATUS";
      event.data = Status(event.utime, number);
      break;
    case 5:  // 64 or 128 bytes with the header.
      event.channel = "BLOCK";
      event.data = RandomBytes((rng.Below(2) == 0 ? 64 : 128) - EventHeader::kBytes - 5, rng);
      break;
    case 6:
      event.channel = "LCM_SELF_TEST";
      for (const char letter : std::string("lcm self test"))
        event.data.push_back(static_cast<std::byte>(letter));
      break;
    case 7:
      event.channel = std::string(63, 'L');
      break;
    case 8:
      for (uint32_t i = rng.Below(5) + 1; i > 0; --i) {
        event.data.resize(event.data.size() + 4);
        StoreBigEndian(EventHeader::kSync, std::span(event.data).last(4));
      }
      break;
    case 9:
      event.data = LogInside(rng.Below(3000), kStart, rng);
      break;
    case 10:
      event.data = LogInside(number + rng.Below(3), event.utime, rng);
      break;
    default:
      event.data = RandomBytes(rng.Below(100), rng);
  }
  return event;
}

}  // namespace

MixedLog MakeMixedLog(int num_events, uint64_t seed) {
  Rng rng(seed);
  MixedLog log;
  for (int64_t i = 0; i < num_events; ++i) {
    log.offsets.push_back(log.bytes.size());
    log.events.push_back(MakeEvent(i, rng));
    Append(log.events.back(), &log.bytes);
  }
  log.offsets.push_back(log.bytes.size());
  return log;
}

MemoryFile::MemoryFile(const std::vector<std::byte>& bytes)
    : descriptor_(memfd_create("log", MFD_CLOEXEC)) {
  EXPECT_EQ(pwrite(descriptor_, bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
}

MemoryFile::~MemoryFile() { close(descriptor_); }

void MemoryFile::Put(size_t offset, std::byte value) const {
  EXPECT_EQ(pwrite(descriptor_, &value, 1, static_cast<off_t>(offset)), 1);
}

std::filesystem::path MemoryFile::path() const { return Format("/proc/self/fd/%d", descriptor_); }

ReadBack ReadDamaged(const std::filesystem::path& file, const MixedLog& log) {
  ReadBack result;
  auto reader = EventLogReader::Open(file);
  EXPECT_TRUE(reader.ok()) << reader.error().message;
  if (!reader) return result;
  size_t next = 0;
  while (const std::optional<LogEventView> event = (*reader)->NextView()) {
    const auto is_it = [&](const LogEvent& written) {
      return event->number == written.number && event->utime == written.utime &&
             event->channel == written.channel && std::ranges::equal(event->data, written.data);
    };
    // It may be one of the next few, if some are missing.
    constexpr size_t kAhead = 4;
    const size_t end = std::min(next + kAhead, log.events.size());
    size_t found = next;
    while (found < end && !is_it(log.events[found])) ++found;
    if (found == end) {
      ++result.num_others;
      continue;
    }
    for (; next < found; ++next) result.missing.push_back(next);
    ++next;
  }
  for (; next < log.events.size(); ++next) result.missing.push_back(next);
  result.damage = (*reader)->damage();
  return result;
}

}  // namespace vantage
