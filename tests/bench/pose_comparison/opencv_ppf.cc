// Point pair features of OpenCV 4.6's surface_matching (ppf_match_3d::PPF3DDetector), with its ICP.
#include <opencv2/surface_matching.hpp>
#include <opencv2/surface_matching/ppf_helpers.hpp>

#include "perception/model/surface_samples.h"
#include "tests/bench/pose_comparison/compared_estimator.h"

namespace vantage {
namespace {

namespace ppf = cv::ppf_match_3d;

// Both samplings are cells of the bounding box's sides.
constexpr double kModelSampling = 0.08;
constexpr double kSceneSampling = 0.08;
constexpr double kDistanceStep = 0.05;    // Of the feature, of the diameter.
constexpr double kSceneStep = 1.0 / 5.0;  // Every fifth scene point is a reference.
// The default mixes units: the relative sampling (as m), and an angle that is converted twice.
constexpr double kClusterDistance = 0.1;  // Of the diameter; poses of a cluster are averaged.
constexpr double kClusterAngle = 0.35;    // rad
constexpr double kDenseModel = 0.01;      // Spacing of the model's samples, of the diameter.
constexpr double kIcpModel = 0.02;        // The same, of those that are registered.
constexpr size_t kRefined = 5;            // Poses with the most votes, as in its sample program.
constexpr int kNormalNeighbors = 12;
constexpr int kIcpIterations = 100;  // These as in its sample program.
constexpr float kIcpTolerance = 0.005F;
constexpr float kIcpRejection = 2.5F;
constexpr int kIcpLevels = 8;

cv::Mat ModelCloud(const ObjectModel& model, double spacing) {
  SurfaceSampleParameters parameters;
  parameters.spacing = spacing;
  Rng rng(1);
  const std::vector<SurfacePoint> samples =
      SampleVisibleSurface(model.mesh, model.diameter, parameters, rng);
  cv::Mat cloud(static_cast<int>(samples.size()), 6, CV_32F);
  for (size_t i = 0; i < samples.size(); ++i) {
    Eigen::Map<Eigen::Matrix<float, 6, 1>>(cloud.ptr<float>(static_cast<int>(i)))
        << samples[i].position,
        samples[i].normal;
  }
  return cloud;
}

class OpenCvPpf : public ComparedEstimator {
 public:
  explicit OpenCvPpf(const ObjectModel& model)
      : detector_(kModelSampling, kDistanceStep),
        icp_model_(ModelCloud(model, kIcpModel)),
        icp_(kIcpIterations, kIcpTolerance, kIcpRejection, kIcpLevels) {
    cv::setNumThreads(1);
    detector_.setSearchParams(kClusterDistance * model.diameter, kClusterAngle, false);
    detector_.trainModel(ModelCloud(model, kDenseModel));
  }

  std::optional<Pose> Estimate(const SegmentedView& view, StageClock* stages) override {
    if (view.points.size() < kNormalNeighbors) return std::nullopt;
    stages->Begin("preparation");
    cv::Mat points(static_cast<int>(view.points.size()), 3, CV_32F);
    for (size_t i = 0; i < view.points.size(); ++i) {
      Eigen::Map<Eigen::Vector3f>(points.ptr<float>(static_cast<int>(i))) = view.points[i];
    }
    cv::Mat scene;
    ppf::computeNormalsPC3d(points, scene, kNormalNeighbors, true, cv::Vec3f(0.0F, 0.0F, 0.0F));
    stages->Begin("matching");
    std::vector<ppf::Pose3DPtr> poses;
    detector_.match(scene, poses, kSceneStep, kSceneSampling);
    if (poses.empty()) return std::nullopt;
    stages->Begin("icp");
    poses.resize(std::min(poses.size(), kRefined));
    icp_.registerModelToScene(icp_model_, scene, poses);
    const auto best = std::min_element(
        poses.begin(), poses.end(), [](const ppf::Pose3DPtr& a, const ppf::Pose3DPtr& b) {
          return a->residual < b->residual;
        });
    stages->End();
    return Pose(Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>((*best)->pose.val));
  }

 private:
  ppf::PPF3DDetector detector_;
  cv::Mat icp_model_;
  ppf::ICP icp_;
};

}  // namespace

std::unique_ptr<ComparedEstimator> MakeOpenCvPpf(const ObjectModel& model) {
  return std::make_unique<OpenCvPpf>(model);
}

}  // namespace vantage
