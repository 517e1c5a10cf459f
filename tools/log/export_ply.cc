#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <utility>

#include "bus/image_conversion.h"
#include "common/format.h"
#include "perception/model/file_bytes.h"
#include "tools/log/color_picture.h"
#include "tools/log/export_output.h"
#include "tools/log/log_exporter.h"
#include "tools/log/view_collector.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "points are written as they lie");

// Always of one length, so that the count can be put in when it is known.
std::string Head(int64_t num_points) {
  std::string count = Format("%jd", intmax_t{num_points});
  const std::string filler(20 - count.size(), ' ');
  return "ply\nformat binary_little_endian 1.0\ncomment meters, world coordinates" + filler +
         "\nelement vertex " + count +
         "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
         "property uchar green\nproperty uchar blue\nend_header\n";
}

struct Points {
  std::string bytes;
  int64_t count = 0;
};

// The color picture when it shows the same pixels as the depth.
std::optional<RgbImage> RegisteredColor(const CameraView& view, const DepthImage& depth) {
  const image_t* color = FindColor(view.images);
  if (color == nullptr || !view.registered || color->width != depth.width ||
      color->height != depth.height) {
    return std::nullopt;
  }
  Result<RgbImage> picture = ColorPicture(*color);
  if (!picture) return std::nullopt;
  return std::move(picture).value();
}

Points PointsOf(const CameraView& view, const DepthImage& depth) {
  constexpr std::array<uint8_t, 3> kGray = {160, 160, 160};
  const std::optional<RgbImage> color = RegisteredColor(view, depth);
  Points points;
  size_t i = 0;
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u, ++i) {
      const double z = depth.depth[i];
      if (!std::isfinite(z)) continue;
      const Eigen::Vector3f p_world =
          (*view.T_world_camera * view.model->Unproject(u, v, z)).cast<float>();
      std::array<char, 15> bytes{};
      std::memcpy(bytes.data(), p_world.data(), 12);
      std::memcpy(bytes.data() + 12, color ? &color->rgb[3 * i] : kGray.data(), 3);
      points.bytes.append(bytes.data(), bytes.size());
      ++points.count;
    }
  }
  return points;
}

class PlyExporter : public LogExporter {
 public:
  PlyExporter(std::unique_ptr<ExportFolder> folder, bool merge)
      : folder_(std::move(folder)), merge_(merge) {}

  Result<void> Add(const LogEventView& event, bool wanted) override {
    return views_.Add(event, wanted);
  }
  Result<std::string> Finish() override;

 private:
  struct Cloud {
    fs::path file;
    int64_t num_points = 0;
    int64_t num_views = 0;
  };

  Result<void> Export(const CameraView& view);

  std::unique_ptr<ExportFolder> folder_;
  bool merge_;
  std::map<std::string, Cloud> clouds_;  // By camera; the last file of it.
  int64_t num_unplaced_ = 0;
  ViewCollector views_{[this](const CameraView& view) { return Export(view); }};
};

Result<void> PlyExporter::Export(const CameraView& view) {
  const Result<DepthFrame> depth = DepthFrameFromMessage(view.images);
  if (!depth || !view.model || !view.T_world_camera || view.model->width != depth->image.width ||
      view.model->height != depth->image.height) {
    ++num_unplaced_;
    return {};
  }
  Cloud& cloud = clouds_[view.camera];
  const Points points = PointsOf(view, depth->image);
  const std::string name = FileNameOf("CAMERA_" + view.camera);
  const int64_t number = cloud.num_views++;
  cloud.num_points += points.count;
  if (!merge_) {
    const Result<fs::path> sub = folder_->Sub(name);
    if (!sub) return sub.error();
    return WriteFileBytes(*sub / Format("view_%06jd.ply", intmax_t{number}),
                          Head(points.count) + points.bytes);
  }
  cloud.file = folder_->path() / (name + ".ply");
  if (number == 0) {
    if (Result<void> begun = AppendToFile(cloud.file, Head(0)); !begun) return begun;
  }
  return AppendToFile(cloud.file, points.bytes);
}

Result<std::string> PlyExporter::Finish() {
  if (Result<void> finished = views_.Finish(); !finished) return finished.error();
  if (clouds_.empty()) {
    return Error{ErrorCode::kNotFound,
                 "no depth images with a pose and a calibration to export, expected CAMERA_<NAME>, "
                 "CAMERA_<NAME>_TO_WORLD and CAMERA_<NAME>_INFO"};
  }
  std::string text;
  for (const auto& [name, cloud] : clouds_) {
    text += Format("CAMERA_%s: %jd views, %jd points\n",
                   name.c_str(),
                   intmax_t{cloud.num_views},
                   intmax_t{cloud.num_points});
    if (!merge_) continue;
    if (Result<void> counted = ReplaceStart(cloud.file, Head(cloud.num_points)); !counted) {
      return counted.error();
    }
  }
  if (num_unplaced_ > 0) {
    text +=
        Format("%jd images without depth, pose or calibration left out\n", intmax_t{num_unplaced_});
  }
  if (Result<void> published = folder_->Publish(); !published) return published.error();
  return text;
}

}  // namespace

Result<std::unique_ptr<LogExporter>> MakePlyExporter(const fs::path& folder, bool merge) {
  Result<std::unique_ptr<ExportFolder>> made = ExportFolder::Create(folder);
  if (!made) return made.error();
  return std::unique_ptr<LogExporter>(new PlyExporter(std::move(made).value(), merge));
}

}  // namespace vantage
