#include <cmath>
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
#include "tools/support/png_image.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTableHead =
    "view,utime_us,seq,depth,color,x_m,y_m,z_m,qw,qx,qy,qz,width_px,height_px,fx_px,fy_px,cx_px,"
    "cy_px\n";
constexpr const char* kWithoutPose = "without_pose";

Gray16Image Millimetres(const DepthImage& depth) {
  Gray16Image image{.width = depth.width, .height = depth.height, .gray = {}};
  image.gray.reserve(depth.depth.size());
  for (const float metres : depth.depth) {
    image.gray.push_back(std::isfinite(metres)
                             ? static_cast<uint16_t>(std::lround(1000.0 * double{metres}))
                             : uint16_t{0});
  }
  return image;
}

std::string PoseText(const Pose& pose) {
  std::string text;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      text += Format("%.17g%s", pose.matrix()(row, column), column == 3 ? "\n" : " ");
    }
  }
  return text;
}

std::string IntrinsicsText(const CameraModel& camera) {
  return Format(
      "%.17g 0 %.17g\n0 %.17g %.17g\n0 0 1\n", camera.fx, camera.cx, camera.fy, camera.cy);
}

// A view's line of the table.
std::string Row(const CameraView& view,
                int64_t number,
                const std::string& depth,
                const std::string& color) {
  std::string row = Format("%jd,%jd,%s,%s,%s",
                           intmax_t{number},
                           intmax_t{view.utime},
                           view.seq < 0 ? "" : Format("%jd", intmax_t{view.seq}).c_str(),
                           depth.c_str(),
                           color.c_str());
  if (view.T_world_camera) {
    const Eigen::Vector3d p = view.T_world_camera->translation();
    const Eigen::Quaterniond q(view.T_world_camera->linear());
    for (const double value : {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()}) {
      row += Format(",%.17g", value);
    }
  } else {
    row += ",,,,,,,";
  }
  if (view.model) {
    const CameraModel& camera = *view.model;
    row += Format(",%d,%d", camera.width, camera.height);
    for (const double value : {camera.fx, camera.fy, camera.cx, camera.cy}) {
      row += Format(",%.17g", value);
    }
  } else {
    row += ",,,,,,";
  }
  return row + "\n";
}

class ImageExporter : public LogExporter {
 public:
  explicit ImageExporter(std::unique_ptr<ExportFolder> folder) : folder_(std::move(folder)) {}

  Result<void> Add(const LogEventView& event, bool wanted) override {
    return views_.Add(event, wanted);
  }
  Result<std::string> Finish() override;

 private:
  struct Camera {
    fs::path folder;
    int64_t num_views = 0;
    int64_t num_without_pose = 0;
    int64_t num_other_intrinsics = 0;
    int64_t num_bad = 0;
    std::string first_bad;
    std::optional<CameraModel> model;  // Of Intrinsic.txt.
  };

  Result<void> Export(const CameraView& view);
  Result<std::string> WriteDepth(const CameraView& view, const std::string& name, Camera* camera);
  Result<std::string> WriteColor(const CameraView& view, const std::string& name, Camera* camera);
  static void NoteBad(const Error& error, Camera* camera);

  std::unique_ptr<ExportFolder> folder_;
  std::map<std::string, Camera> cameras_;
  ViewCollector views_{[this](const CameraView& view) { return Export(view); }};
};

void ImageExporter::NoteBad(const Error& error, Camera* camera) {
  if (camera->num_bad++ == 0) camera->first_bad = error.message;
}

// The name of the file that was written; empty: there is no depth.
Result<std::string> ImageExporter::WriteDepth(const CameraView& view,
                                              const std::string& name,
                                              Camera* camera) {
  const Result<DepthFrame> depth = DepthFrameFromMessage(view.images);
  if (!depth) {
    if (depth.error().code != ErrorCode::kNotFound) NoteBad(depth.error(), camera);
    return std::string();
  }
  std::string file = "depth_" + name + ".png";
  if (!view.T_world_camera) {
    ++camera->num_without_pose;
    std::error_code ignored;
    fs::create_directory(camera->folder / kWithoutPose, ignored);
    file.insert(0, std::string(kWithoutPose) + "/");
  }
  if (Result<void> written = WritePng(camera->folder / file, Millimetres(depth->image)); !written) {
    return written.error();
  }
  return file;
}

Result<std::string> ImageExporter::WriteColor(const CameraView& view,
                                              const std::string& name,
                                              Camera* camera) {
  const image_t* color = FindColor(view.images);
  if (color == nullptr) return std::string();
  const Result<RgbImage> picture = ColorPicture(*color);
  if (!picture) {
    NoteBad(picture.error(), camera);
    return std::string();
  }
  const bool is_jpeg = color->pixelformat == image_t::PIXEL_FORMAT_MJPEG;
  std::string file = "color_" + name;
  file += is_jpeg ? ".jpg" : ".png";
  const Result<void> written =
      is_jpeg ? WriteFileBytes(camera->folder / file,
                               std::string_view(reinterpret_cast<const char*>(color->data.data()),
                                                color->data.size()))
              : WritePng(camera->folder / file, *picture);
  if (!written) return written.error();
  return file;
}

Result<void> ImageExporter::Export(const CameraView& view) {
  Camera& camera = cameras_[view.camera];
  if (camera.folder.empty()) {
    const Result<fs::path> made = folder_->Sub(FileNameOf("CAMERA_" + view.camera));
    if (!made) return made.error();
    camera.folder = *made;
    if (Result<void> begun = AppendToFile(*made / "views.csv", kTableHead); !begun) return begun;
  }
  if (view.model && !camera.model) {
    camera.model = view.model;
    const Result<void> written =
        WriteFileBytes(camera.folder / "Intrinsic.txt", IntrinsicsText(*view.model));
    if (!written) return written;
  }
  if (view.model != camera.model) ++camera.num_other_intrinsics;
  const std::string name = Format("%06jd", intmax_t{camera.num_views});
  const Result<std::string> depth = WriteDepth(view, name, &camera);
  if (!depth) return depth.error();
  const Result<std::string> color = WriteColor(view, name, &camera);
  if (!color) return color.error();
  if (depth->empty() && color->empty()) return {};
  if (!depth->empty() && view.T_world_camera) {
    const std::string text = PoseText(*view.T_world_camera);
    const Result<void> written =
        WriteFileBytes(camera.folder / ("world_T_camera_" + name + ".txt"), text);
    if (!written) return written;
  }
  return AppendToFile(camera.folder / "views.csv", Row(view, camera.num_views++, *depth, *color));
}

Result<std::string> ImageExporter::Finish() {
  if (Result<void> finished = views_.Finish(); !finished) return finished.error();
  std::string text;
  int64_t num_views = 0;
  for (const auto& [name, camera] : cameras_) {
    num_views += camera.num_views;
    text += Format("%s: %jd views\n", camera.folder.filename().c_str(), intmax_t{camera.num_views});
    if (camera.num_without_pose > 0) {
      text += Format("  %jd depth images without a pose are in %s/\n",
                     intmax_t{camera.num_without_pose},
                     kWithoutPose);
    }
    if (!camera.model) text += "  no calibration came, so there is no Intrinsic.txt\n";
    if (camera.num_other_intrinsics > 0) {
      text += Format("  %jd views have other intrinsics than Intrinsic.txt: see views.csv\n",
                     intmax_t{camera.num_other_intrinsics});
    }
    if (camera.num_bad > 0) {
      text += Format("  %jd images left out, the first: %s\n",
                     intmax_t{camera.num_bad},
                     camera.first_bad.c_str());
    }
  }
  if (num_views == 0) {
    return Error{ErrorCode::kNotFound, "no images to export, expected images_t on CAMERA_<NAME>"};
  }
  if (views_.num_malformed() > 0) {
    text += Format("%jd malformed messages left out\n", intmax_t{views_.num_malformed()});
  }
  if (Result<void> published = folder_->Publish(); !published) return published.error();
  return text;
}

}  // namespace

Result<std::unique_ptr<LogExporter>> MakeImageExporter(const fs::path& folder) {
  Result<std::unique_ptr<ExportFolder>> made = ExportFolder::Create(folder);
  if (!made) return made.error();
  return std::unique_ptr<LogExporter>(new ImageExporter(std::move(made).value()));
}

}  // namespace vantage
