// Ours.
#include "common/check.h"
#include "perception/ppf/ppf_estimator.h"
#include "tests/bench/pose_comparison/compared_estimator.h"

namespace vantage {
namespace {

double Seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

class Ppf : public ComparedEstimator {
 public:
  explicit Ppf(const ObjectModel& model)
      : estimator_(CreatePpfEstimator(std::vector<ObjectModel>{model}, Parameters()).value()) {}

  std::optional<Pose> Estimate(const SegmentedView& view, StageClock* stages) override {
    StageTimes times;
    times.clock = Seconds;
    Rng rng(1);
    const double start = Seconds();
    const PoseEstimator::Output& output =
        estimator_->Estimate(view.depth, view.camera, rng, &times);
    const double total = Seconds() - start;
    stages->Add("normals", times.normals);
    stages->Add("voting", times.proposal);
    stages->Add("verification", times.verification);
    stages->Add("refinement", times.refinement);
    // The others get the segment as well.
    stages->Add("rest", total - times.segmentation - 1e-3 * stages->total_ms());
    if (output.detections.empty()) return std::nullopt;
    return output.detections.front().T_camera_object;
  }

 private:
  static PpfEstimatorParameters Parameters() {
    PpfEstimatorParameters parameters;
    parameters.estimation.segmentation.support = SegmentationParameters::Support::kNone;
    return parameters;
  }
  std::unique_ptr<PoseEstimator> estimator_;
};

}  // namespace

std::unique_ptr<ComparedEstimator> MakePpf(const ObjectModel& model) {
  return std::make_unique<Ppf>(model);
}

}  // namespace vantage
