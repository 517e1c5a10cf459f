#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bus/conversions.h"
#include "bus/event_log.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "common/camera_model.h"
#include "common/depth_rasterizer.h"
#include "perception/model/file_bytes.h"
#include "tests/tools/run_fixtures.h"
#include "tools/support/report_setup.h"
#include "tools/support/shaded_scene.h"
#include "vantage/log_header_t.hpp"
#include "vantage/next_view_t.hpp"

namespace vantage {

/// The bundled bracket on a table, seen from three places, 1 s apart.
class RenderedRun {
 public:
  static constexpr int kViews = 3;

  /// The set-up, with the truth in [sim].
  static std::string Config() {
    return "[camera.TEST]\n[models]\nfolder = \"" VANTAGE_SOURCE_DIR
           "/models\"\nuse = [\"bracket\"]\n"
           "[segmentation]\nsupport_plane = \"auto\"\n[ppf]\ncamera = \"TEST\"\nseed = 1\n"
           "[fusion]\nk = 64\nsigma_deg = 4.0\n[planner]\nmax_views = 3\n"
           "[sim]\ncamera = \"TEST\"\n"
           "[[sim.object]]\nmodel = \"bracket\"\nposition_m = [0.03, -0.02, 0.0]\n"
           "rpy_deg = [0.0, 0.0, 40.0]\n";
  }

  /// Writes setup.toml to `folder`.
  explicit RenderedRun(const std::filesystem::path& folder) : config_(folder / "setup.toml") {
    EXPECT_TRUE(WriteFileBytes(config_, Config()).ok());
    Result<ReportSetup> setup = LoadReportSetup(config_);
    EXPECT_TRUE(setup.ok()) << setup.error().message;
    setup_ = std::move(setup).value();
    for (int i = 0; i < kViews; ++i) {
      const double azimuth = (20.0 + 110.0 * i) * kDegree;
      const Eigen::Vector3d eye(0.5 * std::cos(azimuth), 0.5 * std::sin(azimuth), 0.4 + 0.05 * i);
      T_world_cameras_.push_back(LookAt(eye, {0.0, 0.0, 0.03}));
    }
  }

  [[nodiscard]] const std::filesystem::path& config() const { return config_; }
  [[nodiscard]] const ObjectModel& model() const { return setup_.models.at("bracket"); }
  [[nodiscard]] const Pose& T_world_object() const { return setup_.truth.at(0).T_world_object; }
  [[nodiscard]] static int64_t UtimeOf(int view) { return kRunStart + int64_t{1'000'000} * view; }

  /// What a camera and a robot would send. @param header_config of LOG_HEADER; may be empty.
  void WriteInputs(const std::filesystem::path& log, const std::string& header_config) const {
    Write(log, header_config, [](int, EventLogWriter&) {});
  }

  /// The same, with what an estimator and fusion would have said of `count` objects where one is:
  /// single views are off by 5 degrees, the fused estimate of the last view by `angle` rad and
  /// `distance` m. The second object stands 0.3 m aside.
  void WriteRun(const std::filesystem::path& log,
                double angle,
                double distance,
                int count = 1) const {
    Write(log, "", [&](int view, EventLogWriter& writer) {
      WriteFound(view, angle, distance, count, writer);
    });
  }

 private:
  template <class Message>
  static void Put(int64_t utime,
                  const std::string& channel,
                  const Message& message,
                  EventLogWriter& writer) {
    ASSERT_TRUE(writer.Write(utime, channel, Encode(message)).ok());
  }

  template <class AfterView>
  void Write(const std::filesystem::path& log,
             const std::string& header_config,
             const AfterView& after_view) const {
    Result<std::unique_ptr<EventLogWriter>> writer = EventLogWriter::Create(log);
    ASSERT_TRUE(writer.ok()) << writer.error().message;
    log_header_t header{};
    header.utime = UtimeOf(0) - 500'000;
    header.version = "test";
    header.config_text = header_config;
    Put(header.utime, "LOG_HEADER", header, **writer);
    for (int view = 0; view < kViews; ++view) {
      WriteView(view, **writer);
      after_view(view, **writer);
    }
    ASSERT_TRUE((*writer)->Close().ok());
  }

  // The camera rests for 0.4 s before and after the image.
  void WriteView(int view, EventLogWriter& writer) const {
    const Pose& T_world_camera = T_world_cameras_[static_cast<size_t>(view)];
    CameraIdentity identity{};
    identity.name = "TEST";
    const int64_t utime = UtimeOf(view);
    const int64_t start = utime - 400'000;
    Put(start, "CAMERA_TEST_INFO", CameraToMessage(camera_, identity, start, view), writer);
    for (int64_t at = start; at <= utime + 400'000; at += 10'000) {
      Put(at, "CAMERA_TEST_TO_WORLD", PoseToMessage(T_world_camera, at), writer);
      if (at != utime) continue;
      const std::vector<uint16_t> depth = Render(T_world_camera.inverse());
      Put(at,
          "CAMERA_TEST",
          DepthToMessage(
              camera_.width, camera_.height, depth, utime, view, "", DepthCompression::kZlib),
          writer);
    }
  }

  void WriteFound(
      int view, double angle, double distance, int count, EventLogWriter& writer) const {
    DetectionSet set;
    set.utime = UtimeOf(view);
    set.seq = view;
    set.camera = "TEST";
    set.estimator = "ppf";
    set.T_world_camera = T_world_cameras_[static_cast<size_t>(view)];
    const double times = view == kViews - 1 ? 1.0 : 2.0;
    std::vector<object_estimate_v3_t> objects;
    for (int i = 0; i < count; ++i) {
      Detection detection;
      detection.model_id = "bracket";
      detection.T_camera_object = set.T_world_camera.inverse() *
                                  OffBy(T_world_object(), model(), 5.0 * kDegree, {0, 0, 0.004});
      set.detections.push_back(detection);
      const Eigen::Vector3d shift(times * distance, 0.3 * i, 0.0);
      objects.push_back(
          EstimateAt(i, "bracket", OffBy(T_world_object(), model(), times * angle, shift)));
      AddSource("DETECTIONS_PPF", view, i, view, &objects.back());
    }
    const int64_t at = UtimeOf(view) + 500'000;
    Put(at, "DETECTIONS_PPF", DetectionsToMessage(set), writer);
    Put(at, "OBJECTS", ObjectsOf(objects, view + 1, UtimeOf(view)), writer);
    for (int i = 0; i < count; ++i) {
      orientation_histogram_t histogram{};
      histogram.instance_id = i;
      histogram.model_id = "bracket";
      histogram.k = 8;
      for (int32_t cell = 0; cell < 4096; ++cell) {
        histogram.cell.push_back(8 * cell);
        histogram.weight.push_back(1.0F / static_cast<float>(1 + cell));
      }
      histogram.num_cells = static_cast<int32_t>(histogram.cell.size());
      Put(at, "ORIENTATION_HISTOGRAM", histogram, writer);
    }
    next_view_t next{};
    next.reason = "because <it> is far";
    next.selected = -1;
    Put(at, "NEXT_VIEW", next, writer);
  }

  [[nodiscard]] std::vector<uint16_t> Render(const Pose& T_camera_world) const {
    DepthRasterizer rasterizer(camera_);
    rasterizer.Clear();
    rasterizer.Draw(TableMesh({0.0, 0.0, 0.0}, 0.8, 0.8, 0.02), T_camera_world);
    rasterizer.Draw(model().mesh, T_camera_world * T_world_object());
    DepthImage image(camera_.width, camera_.height);
    image.depth.assign(rasterizer.depth().begin(), rasterizer.depth().end());
    return DepthToMillimetres(image);
  }

  std::filesystem::path config_;
  ReportSetup setup_;
  CameraModel camera_;
  std::vector<Pose> T_world_cameras_;
};

}  // namespace vantage
