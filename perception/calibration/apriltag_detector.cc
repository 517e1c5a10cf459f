#include "perception/calibration/apriltag_detector.h"

#include <apriltag/apriltag.h>

#include <algorithm>
#include <map>

namespace vantage {
namespace {

/// How many wrong cells of a tag are set right: as many as leave a distance to other tags that is
/// at least half of the family's, and no more than 2, beyond which libapriltag's tables get large.
int CorrectedBits(const apriltag_family_t& family) {
  return std::min(2, (static_cast<int>(family.h) - 1) / 4);
}

}  // namespace

AprilTagDetector::AprilTagDetector(const CalibrationTarget& target, TagFamily family)
    : target_(target),
      points_(TargetPoints(target)),
      family_(std::move(family)),
      detector_(apriltag_detector_create(), apriltag_detector_destroy) {
  apriltag_detector_add_family_bits(detector_.get(), family_.get(), CorrectedBits(*family_.get()));
  detector_->nthreads = 1;
  detector_->quad_decimate = 1.0F;
  detector_->refine_edges = true;
}

std::vector<TargetPoint> AprilTagDetector::Detect(const GrayImage& image) {
  if (!IsDetectable(image)) return {};
  // libapriltag only reads the picture.
  image_u8_t borrowed{.width = image.width,
                      .height = image.height,
                      .stride = image.width,
                      .buf = const_cast<uint8_t*>(image.pixels.data())};
  const std::unique_ptr<zarray_t, void (*)(zarray_t*)> found(
      apriltag_detector_detect(detector_.get(), &borrowed), apriltag_detections_destroy);
  // A tag that is there twice, in a mirror perhaps, is none.
  std::map<int, std::vector<const apriltag_detection_t*>> by_id;
  for (int i = 0; i < zarray_size(found.get()); ++i) {
    const apriltag_detection_t* tag = nullptr;
    zarray_get(found.get(), i, &tag);
    by_id[tag->id].push_back(tag);
  }
  std::vector<TargetPoint> points;
  for (const auto& [id, tags] : by_id) {
    const int index = id - target_.first_id;
    if (tags.size() != 1 || index < 0 || index >= target_.columns * target_.rows) continue;
    for (size_t corner = 0; corner < 4; ++corner) {
      // libapriltag begins at the bottom left, and goes the other way round. Its (0, 0) is the
      // corner of a pixel.
      const double* pixel = tags[0]->p[3 - corner];
      points.push_back({.p_target = points_[4 * static_cast<size_t>(index) + corner],
                        .pixel = Eigen::Vector2d(pixel[0] - 0.5, pixel[1] - 0.5)});
    }
  }
  return points;
}

}  // namespace vantage
