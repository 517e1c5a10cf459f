// Ours: point pair features, and correspondences of SHOT descriptors.
#include "perception/ppf/ppf_estimator.h"
#include "perception/shot/shot_estimator.h"
#include "tests/bench/pose_comparison/compared_estimator.h"

namespace vantage {
namespace {

double Seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// The same segment as the others get: all pixels that measure.
SegmentationParameters OneSegment() {
  SegmentationParameters parameters;
  parameters.support = SegmentationParameters::Support::kNone;
  parameters.max_depth = 10.0;
  parameters.largest_gap = 10.0;
  parameters.gap_px = 20;
  parameters.min_points = 20;
  parameters.concave_angle_deg = 180.0;
  return parameters;
}

class Ours : public ComparedEstimator {
 public:
  explicit Ours(std::unique_ptr<PoseEstimator> estimator) : estimator_(std::move(estimator)) {}

  std::optional<Pose> Estimate(const SegmentedView& view, StageClock* stages) override {
    StageTimes times;
    times.clock = Seconds;
    Rng rng(1);
    const double start = Seconds();
    const PoseEstimator::Output& output =
        estimator_->Estimate(view.depth, view.camera, rng, &times);
    const double total = Seconds() - start;
    stages->Add("normals", times.normals);
    stages->Add("proposal", times.proposal);
    stages->Add("verification", times.verification);
    stages->Add("refinement", times.refinement);
    // The others get the segment as well.
    stages->Add("rest", total - times.segmentation - 1e-3 * stages->total_ms());
    if (output.detections.empty()) return std::nullopt;
    return output.detections.front().T_camera_object;
  }

 private:
  std::unique_ptr<PoseEstimator> estimator_;
};

}  // namespace

std::unique_ptr<ComparedEstimator> MakePpf(const ObjectModel& model) {
  PpfEstimatorParameters parameters;
  parameters.estimation.segmentation = OneSegment();
  return std::make_unique<Ours>(
      CreatePpfEstimator(std::vector<ObjectModel>{model}, parameters).value());
}

std::unique_ptr<ComparedEstimator> MakeShot(const ObjectModel& model) {
  ShotEstimatorParameters parameters;
  parameters.estimation.segmentation = OneSegment();
  return std::make_unique<Ours>(CreateShotEstimator({model}, parameters).value());
}

}  // namespace vantage
