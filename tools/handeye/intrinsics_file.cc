#include "tools/handeye/intrinsics_file.h"

#include <charconv>
#include <cmath>

#include "common/format.h"
#include "nodes/camera_calibration.h"
#include "perception/model/file_bytes.h"

namespace vantage {
namespace {

constexpr size_t kLargestFile = 1U << 20U;  // bytes

// The number in the first <tag>...</tag> from `from` on.
Result<double> NumberOf(const std::string& xml, size_t from, const char* tag) {
  const std::string opening = Format("<%s>", tag);
  const size_t at = xml.find(opening, from);
  if (at != std::string::npos) {
    const size_t begin = xml.find_first_not_of(" \t\r\n", at + opening.size());
    double value = 0.0;
    if (begin != std::string::npos &&
        std::from_chars(xml.data() + begin, xml.data() + xml.size(), value).ec == std::errc() &&
        std::isfinite(value)) {
      return value;
    }
  }
  return Error{ErrorCode::kCorrupt, Format("has no number in <%s>", tag)};
}

// With the model that knows distortion where there is one.
Result<CameraIntrinsics> ParseVisp(const std::string& xml) {
  const size_t with = xml.find("<type>perspectiveProjWithDistortion</type>");
  const size_t model = with != std::string::npos ? with : 0;
  CameraIntrinsics read;
  double width = 0.0;
  double height = 0.0;
  struct Field {
    const char* tag;
    size_t from;
    double* value;
  };
  for (const Field& field : {Field{"image_width", 0, &width},
                             Field{"image_height", 0, &height},
                             Field{"px", model, &read.camera.fx},
                             Field{"py", model, &read.camera.fy},
                             Field{"u0", model, &read.camera.cx},
                             Field{"v0", model, &read.camera.cy}}) {
    const Result<double> number = NumberOf(xml, field.from, field.tag);
    if (!number) return number.error();
    *field.value = *number;
  }
  if (with != std::string::npos) {
    const Result<double> kud = NumberOf(xml, model, "kud");
    if (!kud) return kud.error();
    read.distortion.k1 = *kud;
  }
  if (!(std::abs(width) < 1e5 && std::abs(height) < 1e5)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("is of an image of %g x %g px", width, height)};
  }
  read.camera.width = static_cast<int>(width);
  read.camera.height = static_cast<int>(height);
  if (Result<void> valid = read.camera.Validate(); !valid) return valid.error();
  return read;
}

}  // namespace

Result<CameraIntrinsics> ReadIntrinsics(const std::filesystem::path& file) {
  if (file.extension() == ".xml") {
    const Result<std::string> xml = ReadFileBytes(file, kLargestFile);
    if (!xml) return xml.error();
    Result<CameraIntrinsics> read = ParseVisp(*xml);
    if (read) return read;
    return Error{read.error().code,
                 Format("intrinsics %s: %s, expected a camera of ViSP",
                        file.c_str(),
                        read.error().message.c_str())};
  }
  const Result<CameraCalibration> calibration = LoadCameraCalibration(file);
  if (!calibration) return calibration.error();
  return calibration->intrinsics;
}

std::string IntrinsicsToml(const CameraIntrinsics& intrinsics) {
  const CameraModel& camera = intrinsics.camera;
  const LensDistortion& k = intrinsics.distortion;
  std::string text = Format(
      "# Intrinsics of a camera, found by vantage-handeye; for calibration = \"...\" of its "
      "driver.\nwidth_px = %d\nheight_px = %d\nfx_px = %.9g\nfy_px = %.9g\ncx_px = %.9g\n"
      "cy_px = %.9g\n",
      camera.width,
      camera.height,
      camera.fx,
      camera.fy,
      camera.cx,
      camera.cy);
  if (k.IsNone()) return text + "distortion_model = \"none\"\n";
  return text + Format(
                    "distortion_model = \"brown_conrady\"\ndistortion = [%.9g, %.9g, %.9g, %.9g, "
                    "%.9g]   # k1 k2 p1 p2 k3\n",
                    k.k1,
                    k.k2,
                    k.p1,
                    k.p2,
                    k.k3);
}

}  // namespace vantage
