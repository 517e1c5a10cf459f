// Makes the log that the test of lcm-spy plays: every message type, what the plugins show, and what
// must not harm them; and a properties file with what they have to show.
//   spy_messages OUT.lcm OUT.properties NOW_UTIME
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "bus/event_log.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "bus/message_schema.h"
#include "bus/wire.h"
#include "common/format.h"
#include "common/rng.h"
#include "common/so3.h"
#include "fusion/so3_grid.h"
#include "tests/bus/support/random_message.h"
#include "tests/common/jpeg_encoder.h"
#include "vantage/detections_v2_t.hpp"
#include "vantage/next_view_t.hpp"
#include "vantage/object_estimates_v3_t.hpp"
#include "vantage/orientation_histogram_t.hpp"
#include "vantage/process_status_t.hpp"

namespace vantage {
namespace {

constexpr int kWidth = 320;   // px
constexpr int kHeight = 240;  // px
constexpr int kTurns = 80;
constexpr int64_t kTurnUs = 500'000;
constexpr int kGridK = 32;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// A ramp from 600 to 1399 mm in the middle, nothing in the outer fifth on each side.
std::vector<uint16_t> DepthRamp() {
  std::vector<uint16_t> millimetres(size_t{kWidth} * kHeight, 0);
  for (size_t v = 0; v < kHeight; ++v) {
    for (size_t u = kWidth / 5; u < kWidth - kWidth / 5; ++u) {
      millimetres[v * kWidth + u] = static_cast<uint16_t>(600 + 800 * v / kHeight);
    }
  }
  return millimetres;
}

images_t DepthMessage(int64_t utime, int64_t seq, DepthCompression compression) {
  return DepthToMessage(kWidth, kHeight, DepthRamp(), utime, seq, "TEST", compression);
}

// Upper half red, lower half green.
std::vector<uint8_t> TwoColors(int width, int height) {
  constexpr std::array<uint8_t, 3> kRed = {200, 20, 30};
  constexpr std::array<uint8_t, 3> kGreen = {20, 180, 30};
  std::vector<uint8_t> rgb;
  for (int pixel = 0; pixel < width * height; ++pixel) {
    const auto& color = pixel < width * height / 2 ? kRed : kGreen;
    rgb.insert(rgb.end(), color.begin(), color.end());
  }
  return rgb;
}

image_t ColorImage(int64_t utime, bool jpeg) {
  image_t image{};
  image.utime = utime;
  image.width = 160;
  image.height = 120;
  image.row_stride = jpeg ? 0 : 3 * image.width;
  image.pixelformat = image_t::PIXEL_FORMAT_RGB;
  if (jpeg) image.pixelformat = image_t::PIXEL_FORMAT_MJPEG;
  const std::vector<uint8_t> rgb = TwoColors(image.width, image.height);
  image.data = jpeg ? EncodeJpeg(rgb, image.width, image.height, 3) : rgb;
  return image;
}

// All weight within 8 degrees of an orientation.
orientation_histogram_t Histogram(const Eigen::Quaterniond& about, int instance, int64_t utime) {
  static const So3Grid kGrid(kGridK);
  std::vector<So3Grid::NearCell> cells;
  kGrid.CellsWithin(about, 8.0 * kDegree, &cells);
  orientation_histogram_t message{};
  message.utime = utime;
  message.instance_id = instance;
  message.model_id = instance == 7 ? "mug" : "filter";
  message.k = kGridK;
  for (const So3Grid::NearCell& near : cells) {
    message.cell.push_back(near.cell);
    message.weight.push_back(
        static_cast<float>(std::exp(-0.5 * near.squared_angle / std::pow(3.0 * kDegree, 2))));
  }
  message.num_cells = static_cast<int32_t>(cells.size());
  return message;
}

object_estimates_v3_t Objects(int64_t utime, int64_t seq) {
  object_estimates_v3_t message{};
  message.utime = utime;
  message.seq = seq;
  message.num_viewpoints = 5;
  for (const char* model : {"mug", "filter", "<html><b>bold"}) {
    object_estimate_v3_t object{};
    object.instance_id = static_cast<int32_t>(7 + message.objects.size());
    object.model_id = model;
    object.state =
        message.objects.empty() ? object_estimate_v3_t::CONFIRMED : object_estimate_v3_t::LOST;
    object.trans[0] = message.objects.size() == 2 ? kNan : 0.125;
    orientation_peak_v2_t peak{};
    peak.quat[0] = 1.0;
    peak.weight = 0.75;
    peak.spread = 2.0 * kDegree;
    object.peaks.assign(2, peak);
    object.num_peaks = 2;
    object.num_views = 5;
    object.last_change = -1.0;
    object.refinement = object_estimate_v3_t::REFINED;
    for (size_t i = 0; i < 3; ++i) {
      object.refined_covariance[7 * i] = std::pow(0.3 * kDegree, 2) / 3.0;
      object.refined_covariance[7 * (i + 3)] = std::pow(0.002, 2) / 3.0;
    }
    message.objects.push_back(object);
  }
  message.num_objects = static_cast<int32_t>(message.objects.size());
  return message;
}

detections_v2_t Detections(int64_t utime, int64_t seq) {
  detections_v2_t message{};
  message.utime = utime;
  message.seq = seq;
  message.camera = "TEST";
  message.estimator = "ppf";
  detection_v2_t detection{};
  detection.model_id = "bracket";
  detection.trans[2] = 0.75;
  detection.quat[0] = 1.0;
  detection.mse = 4e-6;
  detection.verification_score = 0.875;
  message.detections.push_back(detection);
  message.num_detections = 1;
  return message;
}

next_view_t NextView(int64_t utime) {
  next_view_t message{};
  message.utime = utime;
  message.criterion = "farthest";
  message.selected = 2;
  message.reason = "it is farthest";
  for (int i = 0; i < 5; ++i) {
    view_candidate_t candidate{};
    candidate.gain = i == 4 ? kNan : 0.5 * i;
    candidate.reachable = i == 3 ? 0 : 1;
    candidate.reason = i == 3 ? "too far" : "";
    message.candidates.push_back(candidate);
  }
  message.num_candidates = 5;
  return message;
}

process_status_t ProcessStatus(const std::string& name, int64_t utime) {
  process_status_t message{};
  message.utime = utime;
  message.name = name;
  message.host = "here";
  message.state = name == "ppf" ? "ok" : "no camera";
  channel_status_t channel{};
  channel.channel = "CAMERA_TEST";
  channel.num_lost = 3;
  message.channels.push_back(channel);
  message.num_channels = 1;
  stage_status_t stage{};
  stage.stage = "match";
  stage.latency_p99 = 0.125;
  message.stages.push_back(stage);
  message.num_stages = 1;
  return message;
}

// Cells outside of the grid, weights that are none, and few sound ones.
orientation_histogram_t HostileHistogram(orientation_histogram_t message) {
  const auto add = [&message](int32_t cell, float weight) {
    message.cell.push_back(cell);
    message.weight.push_back(weight);
  };
  add(-1, 1.0F);
  add(std::numeric_limits<int32_t>::max(), 1.0F);
  add(0, 1.0F);  // A corner of the lattice, far from the sphere.
  add(message.cell[0], std::numeric_limits<float>::quiet_NaN());
  add(message.cell[0], -1.0F);
  message.num_cells += 5;
  return message;
}

class LogOfMessages {
 public:
  explicit LogOfMessages(EventLogWriter& log) : log_(log) {}

  void SetTime(int64_t utime) { utime_ = utime; }
  void AddBytes(const std::string& channel, std::span<const std::byte> bytes) {
    // Apart by 1 ms: a burst is lost in Java's receive buffer.
    if (Result<void> written = log_.Write(utime_ += 1000, channel, bytes); !written) {
      std::fprintf(stderr, "%s\n", written.error().message.c_str());
      std::exit(1);
    }
  }
  template <class Message>
  void Add(const std::string& channel, const Message& message) {
    AddBytes(channel, Encode(message));
  }

 private:
  EventLogWriter& log_;
  int64_t utime_ = 0;
};

void AddSound(int64_t utime, int64_t seq, LogOfMessages& log) {
  images_t both = DepthMessage(utime, seq, DepthCompression::kVdc);
  AppendImage(images_t::LEFT, ColorImage(utime, false), &both);
  log.Add("CAMERA_TEST", both);
  log.Add("CAMERA_ZLIB", DepthMessage(utime, seq, DepthCompression::kZlib));
  images_t color{};
  color.utime = utime;
  AppendImage(images_t::LEFT, ColorImage(utime, true), &color);
  log.Add("CAMERA_JPEG", color);
  log.Add("OBJECTS", Objects(utime, seq));
  log.Add("DETECTIONS_TEST", Detections(utime, seq));
  log.Add("NEXT_VIEW", NextView(utime));
  log.Add("PROCESS_STATUS", ProcessStatus("ppf", utime));
  log.Add("PROCESS_STATUS", ProcessStatus("fusion", utime));
}

void AddHostile(int64_t utime, int64_t seq, LogOfMessages& log) {
  const std::vector<std::byte> sound = Encode(DepthMessage(utime, seq, DepthCompression::kVdc));
  std::vector<std::byte> huge_count(sound.begin(), sound.begin() + 64);
  StoreBigEndian<int32_t>(0x7fffffff, std::span(huge_count).subspan(16));
  images_t huge = DepthMessage(utime, seq, DepthCompression::kNone);
  huge.images[0].width = std::numeric_limits<int32_t>::max();
  huge.images[0].data.resize(100);
  huge.images[0].size = 100;
  images_t damaged = DepthMessage(utime, seq, DepthCompression::kVdc);
  damaged.images[0].data[20] ^= 1U;
  log.AddBytes("CAMERA_HOSTILE", sound);
  if (seq > 0) {  // The first says what the channel's type is.
    log.AddBytes("CAMERA_HOSTILE", std::span(sound).first(sound.size() / 2));
    log.AddBytes("CAMERA_HOSTILE", huge_count);
    log.AddBytes("CAMERA_HOSTILE", std::span(sound).first(3));
    log.Add("CAMERA_HOSTILE", huge);
    log.Add("CAMERA_HOSTILE", damaged);
  }
  std::vector<std::byte> foreign(40, std::byte{0x5a});
  log.AddBytes("SOMEONE_ELSES", foreign);
}

int Run(const std::string& log_file, const std::string& facts_file, int64_t utime) {
  Result<std::unique_ptr<EventLogWriter>> writer = EventLogWriter::Create(log_file);
  if (!writer) {
    std::fprintf(stderr, "%s\n", writer.error().message.c_str());
    return 1;
  }
  LogOfMessages log(**writer);
  Rng rng(1);
  const Eigen::Quaterniond q_mug = Eigen::Quaterniond(0.6, -0.3, 0.5, 0.2).normalized();
  const Eigen::Quaterniond q_filter = Eigen::Quaterniond(0.1, 0.7, -0.4, 0.5).normalized();
  int64_t histogram_seq = 0;
  for (int turn = 0; turn < kTurns; ++turn) {
    const int64_t now = utime + turn * kTurnUs;
    log.SetTime(now);
    AddSound(now, turn, log);
    AddHostile(now, turn, log);
    for (orientation_histogram_t histogram :
         {Histogram(q_mug, 7, now), Histogram(q_filter, 8, now)}) {
      histogram.seq = histogram_seq++;
      log.Add("ORIENTATION_HISTOGRAM", histogram);
      log.Add("HISTOGRAM_HOSTILE", HostileHistogram(histogram));
    }
    for (const MessageSchema& schema : AllSchemas()) {
      std::string channel = "TYPE_";
      channel += schema.name;
      log.AddBytes(channel, RandomMessage(schema, 3, rng));
    }
  }
  if (Result<void> closed = (*writer)->Close(); !closed) return 1;

  std::ofstream facts(facts_file);
  const auto tell = [&facts](const char* name, const Eigen::Quaterniond& q) {
    facts << name << "=" << Format("%.9f %.9f %.9f %.9f", q.w(), q.x(), q.y(), q.z()) << "\n";
  };
  tell("q.mug", q_mug);
  tell("q.filter", q_filter);
  facts << "types=" << AllSchemas().size() << "\n";
  return facts.flush() ? 0 : 1;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: spy_messages OUT.lcm OUT.properties NOW_UTIME\n");
    return 2;
  }
  return vantage::Run(argv[1], argv[2], std::stoll(argv[3]));
}
