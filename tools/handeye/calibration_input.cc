#include "tools/handeye/calibration_input.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "common/format.h"
#include "perception/calibration/target_pose.h"
#include "tools/handeye/gray_image_file.h"

namespace vantage {
namespace {

constexpr size_t kFewestPoints = 4;  // Of a pose.

// Ids of the tags of the target's family in an image, in whatever place.
std::vector<int> SeenTags(const CalibrationTarget& target, const GrayImage& image) {
  constexpr int kRow = 50;
  std::vector<int> seen;
  CalibrationTarget row = target;
  row.columns = kRow;
  row.rows = 1;
  for (row.first_id = 0;; row.first_id += kRow) {
    // The family ends within a row.
    while (row.columns > 0 && !row.Validate().ok()) --row.columns;
    if (row.columns == 0) return seen;
    const Result<std::unique_ptr<TargetDetector>> detector = MakeTargetDetector(row);
    if (!detector) return seen;
    const std::vector<Eigen::Vector3d> corners = TargetPoints(row);
    for (const TargetPoint& point : (*detector)->Detect(image)) {
      const auto at = std::ranges::find(corners, point.p_target) - corners.begin();
      if (at % 4 == 0) seen.push_back(row.first_id + static_cast<int>(at / 4));
    }
  }
}

std::string List(const std::vector<int>& ids) {
  std::string text;
  for (const int id : ids) text += Format("%s%d", text.empty() ? "" : ", ", id);
  return text;
}

Error InView(const std::string& name, const char* what, const Error& error) {
  return {error.code, Format("%s: %s: %s", name.c_str(), what, error.message.c_str())};
}

}  // namespace

Result<CalibrationInput> InputFromPoses(HandEyeSetup setup,
                                        std::vector<RawView> views,
                                        uint64_t seed) {
  CalibrationInput input;
  input.raw = std::move(views);
  for (const RawView& view : input.raw) {
    const Result<Pose> hand = PoseFromRaw(view.hand);
    const Result<Pose> camera = PoseFromRaw(view.camera);
    if (!hand || !camera) {
      const Error& error = hand ? camera.error() : hand.error();
      const InputDiagnosis diagnosis =
          DiagnoseInput(setup, input.raw, InputSource::kPosesAndPoses, seed);
      return Error{error.code,
                   Format("%s: pose of the %s: %s%s%s",
                          view.name.c_str(),
                          hand ? "camera" : "robot",
                          error.message.c_str(),
                          diagnosis.mistakes.empty() ? "" : "; ",
                          diagnosis.mistakes.empty() ? "" : diagnosis.Text().c_str())};
    }
    input.poses.push_back(
        {.name = view.name, .utime = view.utime, .T_base_hand = *hand, .T_camera_target = *camera});
  }
  return input;
}

Result<ImageInput> ImageInput::Make(const CalibrationTarget& target,
                                    const CameraIntrinsics& intrinsics,
                                    double pixel_sigma) {
  Result<std::unique_ptr<TargetDetector>> detector = MakeTargetDetector(target);
  if (!detector) return detector.error();
  ImageInput input;
  input.detector_ = std::move(detector).value();
  input.input_.source = InputSource::kPosesAndImages;
  input.input_.intrinsics = intrinsics;
  input.target_ = target;
  input.pixel_sigma_ = pixel_sigma;
  return input;
}

Result<void> ImageInput::Add(const NamedImage& image) {
  const Result<Pose> hand = PoseFromRaw(image.hand);
  if (!hand) return InView(image.name, "pose of the robot", hand.error());
  const CameraModel& camera = input_.intrinsics->camera;
  if (image.image.width != camera.width || image.image.height != camera.height) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s has %d x %d px, expected %d x %d px as the camera's intrinsics",
                        image.name.c_str(),
                        image.image.width,
                        image.image.height,
                        camera.width,
                        camera.height)};
  }
  ++num_images_;
  std::vector<TargetPoint> points = detector_->Detect(image.image);
  if (points.size() < kFewestPoints) {
    input_.notes.push_back(Format("%s is left out: the target is not seen", image.name.c_str()));
    if (target_.kind == CalibrationTarget::Kind::kAprilTags && seen_tags_.empty()) {
      seen_tags_ = SeenTags(target_, image.image);
    }
    return {};
  }
  const Result<std::vector<TargetPose>> poses =
      FindTargetPoses(points, camera, input_.intrinsics->distortion, pixel_sigma_);
  if (!poses) {
    input_.notes.push_back(
        Format("%s is left out: %s", image.name.c_str(), poses.error().message.c_str()));
    return {};
  }
  input_.raw.push_back(
      {image.name, image.utime, image.hand, RawFromPose(poses->front().T_camera_target)});
  input_.images.push_back({image.name, image.utime, *hand, std::move(points)});
  return {};
}

Result<CalibrationInput> ImageInput::Finish() {
  if (input_.images.empty()) {
    return Error{ErrorCode::kNotFound,
                 Format("the target is seen in none of %zu images, expected at least 3: are its "
                        "kind, columns, rows, family and first id right?%s%s",
                        num_images_,
                        seen_tags_.empty() ? "" : " There are tags with other ids: ",
                        List(seen_tags_).c_str())};
  }
  return std::move(input_);
}

Result<CalibrationInput> InputFromFolder(const ImageFolderLayout& layout,
                                         const CalibrationTarget& target,
                                         const CameraIntrinsics& intrinsics,
                                         double pixel_sigma) {
  const Result<std::vector<FolderImage>> files = ReadImageFolder(layout);
  if (!files) return files.error();
  Result<ImageInput> input = ImageInput::Make(target, intrinsics, pixel_sigma);
  if (!input) return input.error();
  for (const FolderImage& each : *files) {
    Result<GrayImage> image = ReadGrayImage(each.file);
    if (!image) return image.error();
    const NamedImage named{
        each.file.filename().string(), each.utime, each.hand, std::move(image).value()};
    if (Result<void> added = input->Add(named); !added) return added.error();
  }
  return input->Finish();
}

}  // namespace vantage
