#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bus/event_log.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "nodes/config_reader.h"
#include "perception/model/file_bytes.h"
#include "tests/tools/rendered_run.h"
#include "tools/replay/replay_run.h"
#include "vantage/detections_v2_t.hpp"
#include "vantage/images_t.hpp"

namespace vantage {

using LogEvents = std::vector<LogEvent>;

inline LogEvents ReadEvents(const std::filesystem::path& log) {
  LogEvents events;
  auto reader = EventLogReader::Open(log);
  EXPECT_TRUE(reader.ok()) << reader.error().message;
  if (!reader.ok()) return events;
  while (std::optional<LogEvent> event = (*reader)->Next()) events.push_back(std::move(*event));
  return events;
}

inline void WriteEvents(const LogEvents& events, const std::filesystem::path& log) {
  auto writer = EventLogWriter::Create(log);
  ASSERT_TRUE(writer.ok()) << writer.error().message;
  for (const LogEvent& event : events) {
    ASSERT_TRUE((*writer)->Write(event.utime, event.channel, event.data).ok());
  }
  ASSERT_TRUE((*writer)->Close().ok());
}

inline void SortByTime(LogEvents* events) {
  std::ranges::stable_sort(*events, {}, &LogEvent::utime);
}

/// What was sent on a channel, in its order.
inline std::vector<std::vector<std::byte>> MessagesOn(const std::string& channel,
                                                      const LogEvents& events) {
  std::vector<std::vector<std::byte>> messages;
  for (const LogEvent& event : events) {
    if (event.channel == channel) messages.push_back(event.data);
  }
  return messages;
}

/// Changes messages of a type on a channel.
template <class Message>
void Edit(const std::string& channel,
          const std::function<void(Message*)>& change,
          LogEvents* events) {
  for (LogEvent& event : *events) {
    if (event.channel != channel) continue;
    Message message = DecodeChecked<Message>(event.data).value();
    change(&message);
    event.data = Encode(message);
  }
}

/// What a camera that takes an image every 40 ms and rests at three places would have sent, with
/// seven images of each place, numbered from 0.
inline LogEvents CameraRun(const std::filesystem::path& folder) {
  RenderedRun(folder).WriteInputs(folder / "rendered.lcm", RenderedRun::Config());
  LogEvents events;
  int64_t seq = 0;
  for (const LogEvent& event : ReadEvents(folder / "rendered.lcm")) {
    if (event.channel != "CAMERA_TEST") {
      events.push_back(event);
      continue;
    }
    const images_t image = DecodeChecked<images_t>(event.data).value();
    const DepthFrame frame = DepthFrameFromMessage(image).value();
    for (int i = -3; i <= 3; ++i) {
      LogEvent copy = event;
      copy.utime += 40'000 * i;
      // No two are the same.
      std::vector<uint16_t> depth = DepthToMillimetres(frame.image);
      for (size_t pixel = 0; pixel < depth.size(); pixel += 97) {
        if (depth[pixel] != 0) depth[pixel] = static_cast<uint16_t>(depth[pixel] + i);
      }
      copy.data = Encode(DepthToMessage(frame.image.width,
                                        frame.image.height,
                                        depth,
                                        copy.utime,
                                        seq++,
                                        "",
                                        DepthCompression::kVdc));
      events.push_back(std::move(copy));
    }
  }
  SortByTime(&events);
  return events;
}

/// Options for a rerun of `log` with the configuration of RenderedRun.
inline ReplayOptions RunOptions(const std::filesystem::path& log,
                                const std::filesystem::path& output) {
  ReplayOptions options;
  options.log = log;
  options.output = output;
  options.open_config = [] { return ConfigReader::Parse(RenderedRun::Config(), "setup.toml"); };
  return options;
}

inline Result<ReplaySummary> RunReplay(const ReplayOptions& options) {
  return RunReplay(options, [](double, int64_t) {});
}

inline std::string FileBytes(const std::filesystem::path& file) {
  const Result<std::string> bytes = ReadFileBytes(file, size_t{1} << 28U);
  EXPECT_TRUE(bytes.ok()) << bytes.error().message;
  return bytes.ok() ? *bytes : "";
}

}  // namespace vantage
