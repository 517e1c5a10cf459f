#include "drivers/camera/rectification.h"

#include <numbers>
#include <utility>

#include "common/format.h"

namespace vantage {
namespace {

bool IsFieldOfView(double angle) { return angle > 0.0 && angle < std::numbers::pi; }

// Of the images that `details` tell the size of; nothing without a calibration.
const CameraIntrinsics* MainIntrinsics(const StreamDetails& details,
                                       const std::optional<CameraCalibration>& calibration) {
  if (!calibration) return nullptr;
  const bool is_color = details.has_depth && details.registered && calibration->color;
  return is_color ? &*calibration->color : &calibration->intrinsics;
}

// Of color images; nothing where that is not known.
const CameraIntrinsics* ColorIntrinsics(const StreamDetails& details,
                                        const std::optional<CameraCalibration>& calibration) {
  if (!calibration) return nullptr;
  if (!details.has_depth) return &calibration->intrinsics;
  return calibration->color ? &*calibration->color : nullptr;
}

// What a registration can't be calculated without; empty when it is all there.
std::string Lacking(const std::optional<CameraCalibration>& calibration) {
  if (!calibration) return "there is no calibration file to calculate it by";
  if (!calibration->color) return "the calibration file has no [color]";
  if (!calibration->T_color_depth) return "the calibration file has no [color_from_depth]";
  return {};
}

// Of a color image's pixels; 0: it has none that can be read.
int Channels(PixelLayout layout) {
  if (layout == PixelLayout::kRgb8) return 3;
  return layout == PixelLayout::kGray8 ? 1 : 0;
}

}  // namespace

Result<Rectification> Rectification::Create(const StreamDetails& details,
                                            const StreamRequest& request,
                                            const std::optional<CameraCalibration>& calibration) {
  Rectification made;
  made.width_ = details.width;
  made.height_ = details.height;
  if (Result<void> found = made.FindModel(details, calibration); !found) return found.error();
  made.PlanRegistration(details, request, calibration);
  made.PlanUndistortion(details, request, calibration);
  return made;
}

Result<void> Rectification::FindModel(const StreamDetails& details,
                                      const std::optional<CameraCalibration>& calibration) {
  const auto reject = [](const std::string& reason) {
    return Error{ErrorCode::kUnavailable, reason};
  };
  if (const CameraIntrinsics* intrinsics = MainIntrinsics(details, calibration)) {
    model_ = intrinsics->camera;
    if (model_->width != details.width || model_->height != details.height) {
      return reject(Format("gives images of %d x %d px, expected the %d x %d px of the calibration",
                           details.width,
                           details.height,
                           model_->width,
                           model_->height));
    }
  } else if (details.horizontal_fov != 0.0 || details.vertical_fov != 0.0) {
    if (!IsFieldOfView(details.horizontal_fov) || !IsFieldOfView(details.vertical_fov)) {
      return reject(
          Format("reports a field of view of %g x %g rad, expected each between 0 and pi; "
                 "a calibration file can stand in for it",
                 details.horizontal_fov,
                 details.vertical_fov));
    }
    model_ = CameraFromFieldOfView(
        details.width, details.height, details.horizontal_fov, details.vertical_fov);
  } else {
    AddNote("it does not tell its field of view, and no calibration file does");
    return {};
  }
  return model_->Validate();
}

void Rectification::PlanRegistration(const StreamDetails& details,
                                     const StreamRequest& request,
                                     const std::optional<CameraCalibration>& calibration) {
  registered_ = details.registered;
  const bool to_color = request.registration == Registration::kDepthToColor;
  if (registered_ || request.registration == Registration::kNone) return;
  const char* what = to_color ? "depth to color" : "color to depth";
  if (!details.has_depth || (!to_color && !details.has_color)) {
    AddNote(Format(
        "it gives no %s, so %s can't be registered", details.has_depth ? "color" : "depth", what));
  } else if (!to_color && request.color_layout == PixelLayout::kJpeg) {
    AddNote("JPEG images can't be registered to depth, expected RGB or gray ones");
  } else if (const std::string lacking = Lacking(calibration); !lacking.empty()) {
    AddNote(Format("it can't register %s, and %s", what, lacking.c_str()));
  } else if (to_color) {
    depth_to_color_.emplace(
        calibration->intrinsics, calibration->color->camera, *calibration->T_color_depth);
    model_ = calibration->color->camera;
    width_ = model_->width;
    height_ = model_->height;
    registered_ = true;
  } else {
    color_to_depth_.emplace(*model_, *calibration->color, *calibration->T_color_depth);
    registered_ = true;
  }
}

void Rectification::PlanUndistortion(const StreamDetails& details,
                                     const StreamRequest& request,
                                     const std::optional<CameraCalibration>& calibration) {
  const CameraIntrinsics* intrinsics = MainIntrinsics(details, calibration);
  if (details.has_depth && intrinsics != nullptr && !intrinsics->distortion.IsNone() &&
      !depth_to_color_) {
    depth_map_ = UndistortionMap(*intrinsics);
  }
  const CameraIntrinsics* color = ColorIntrinsics(details, calibration);
  if (color == nullptr) return;
  color_ = *color;
  if (color->distortion.IsNone()) return;
  if (request.color_layout == PixelLayout::kJpeg) {
    if (details.has_depth) AddNote("color comes as JPEG images, so its distortion stays in it");
  } else if (!color_to_depth_) {
    color_undistortion_.emplace(*color);
  }
}

void Rectification::AddNote(const std::string& sentence) {
  note_ += (note_.empty() ? "" : "; ") + sentence;
}

std::string Rectification::Apply(CameraFrame* frame) {
  frame->width = width_;
  frame->height = height_;
  frame->model = model_;
  frame->registered = registered_;
  if (depth_to_color_) {
    std::vector<uint16_t> registered;
    depth_to_color_->Register(frame->depth_mm, &registered);
    frame->depth_mm = std::move(registered);
  } else if (!depth_map_.empty()) {
    frame->depth_mm = Undistort(frame->depth_mm, depth_map_);
  }
  return frame->color && color_ ? RectifyColor(frame) : std::string();
}

std::string Rectification::RectifyColor(CameraFrame* frame) {
  ColorImage& color = *frame->color;
  const CameraModel& camera = color_->camera;
  if (color.width != camera.width || color.height != camera.height) {
    return Format("color frame of %d x %d px, expected the %d x %d px of the calibration",
                  color.width,
                  color.height,
                  camera.width,
                  camera.height);
  }
  const int channels = Channels(color.layout);
  if (channels == 0) {
    if (frame->depth_mm.empty()) {
      frame->distortion = color_->distortion;
    } else if (!color_->distortion.IsNone()) {
      frame->registered = false;
    }
  } else if (color_to_depth_) {
    std::vector<uint8_t> registered;
    color_to_depth_->Register(frame->depth_mm, channels, color.data, &registered);
    color.data = std::move(registered);
    color.width = width_;
    color.height = height_;
  } else if (color_undistortion_) {
    color_undistortion_->Undistort(channels, &color.data);
  }
  return {};
}

}  // namespace vantage
