// Point pair features of OpenCV 4.6's surface_matching (ppf_match_3d::PPF3DDetector), with its ICP.
#include <opencv2/surface_matching.hpp>
#include <opencv2/surface_matching/ppf_helpers.hpp>

#include "tests/bench/pose_comparison/compared_estimator.h"
#include "tests/bench/pose_comparison/pcl_clouds.h"

namespace vantage {
namespace {

namespace ppf = cv::ppf_match_3d;

// Both samplings are cells of the bounding box's sides. With 0.05 training takes up to 40 s.
constexpr double kModelSampling = 0.08;
constexpr double kSceneSampling = 0.08;
constexpr double kDistanceStep = 0.05;    // Of the feature, of the diameter.
constexpr double kSceneStep = 1.0 / 5.0;  // Every fifth scene point is a reference.
// The default mixes units: the relative sampling (as m), and an angle that is converted twice. The
// clusters whose poses are averaged are kept small: only the angles of rotations are compared, not
// their axes.
constexpr double kClusterDistance = 0.03;  // Of the diameter.
constexpr double kClusterAngle = 0.1;      // rad
// Lengths are relative to the diameter.
constexpr double kDenseModel = 0.01;    // Spacing of the samples that the model is trained with.
constexpr double kIcpModel = 0.02;      // The same, of those that the scene is registered to.
constexpr double kScene = 0.02;         // The same, of the scene's points.
constexpr double kNormalRadius = 0.06;  // About a point.
constexpr size_t kRefined = 5;          // Poses with the most votes, as in its sample program.
constexpr int kIcpIterations = 100;     // These as in its sample program.
constexpr float kIcpTolerance = 0.005F;
constexpr float kIcpRejection = 2.5F;
constexpr int kIcpLevels = 8;

cv::Mat ToMat(const PclSurface& surface) {
  cv::Mat cloud(static_cast<int>(surface.size()), 6, CV_32F);
  for (size_t i = 0; i < surface.size(); ++i) {
    Eigen::Map<Eigen::Matrix<float, 6, 1>>(cloud.ptr<float>(static_cast<int>(i)))
        << surface[i].getVector3fMap(),
        surface[i].getNormalVector3fMap();
  }
  return cloud;
}

using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

// The library averages quaternions without normalizing them: its rotations have a scale.
Pose ToPose(const cv::Matx44d& motion) {
  const Eigen::Affine3d scaled(Matrix4(Eigen::Map<const Matrix4>(motion.val)));
  Pose pose(Pose::Identity());
  pose.linear() = scaled.rotation();
  pose.translation() = scaled.translation();
  return pose;
}

cv::Matx44d InverseMotion(const cv::Matx44d& motion) {
  cv::Matx44d inverse;
  Eigen::Map<Matrix4>(inverse.val) = ToPose(motion).inverse().matrix();
  return inverse;
}

// The scene is registered to the model: what the camera doesn't see of the model has no say. Its
// own normals (of a number of neighbors, not of a radius) are too noisy, so PCL's are taken.
class OpenCvPpf : public ComparedEstimator {
 public:
  explicit OpenCvPpf(const ObjectModel& model)
      : diameter_(model.diameter),
        detector_(kModelSampling, kDistanceStep),
        icp_model_(ToMat(*ModelSurface(model, kIcpModel))),
        icp_(kIcpIterations, kIcpTolerance, kIcpRejection, kIcpLevels) {
    cv::setNumThreads(1);
    detector_.setSearchParams(kClusterDistance * diameter_, kClusterAngle, false);
    detector_.trainModel(ToMat(*ModelSurface(model, kDenseModel)));
  }

  std::optional<Pose> Estimate(const SegmentedView& view, StageClock* stages) override {
    stages->Begin("preparation");
    const double leaf = kScene * diameter_;
    const PclSurface::Ptr surface =
        SceneSurface(view.points, leaf, leaf, kNormalRadius * diameter_);
    if (surface->empty()) return std::nullopt;
    const cv::Mat scene = ToMat(*surface);
    stages->Begin("matching");
    std::vector<ppf::Pose3DPtr> poses;
    detector_.match(scene, poses, kSceneStep, kSceneSampling);
    if (poses.empty()) return std::nullopt;
    stages->Begin("icp");
    poses.resize(std::min(poses.size(), kRefined));
    for (const ppf::Pose3DPtr& pose : poses) {
      cv::Matx44d T_object_camera = InverseMotion(pose->pose);
      pose->updatePose(T_object_camera);
    }
    icp_.registerModelToScene(scene, icp_model_, poses);
    const auto best = std::min_element(
        poses.begin(), poses.end(), [](const ppf::Pose3DPtr& a, const ppf::Pose3DPtr& b) {
          return a->residual < b->residual;
        });
    return ToPose((*best)->pose).inverse();
  }

 private:
  double diameter_;
  ppf::PPF3DDetector detector_;
  cv::Mat icp_model_;
  ppf::ICP icp_;
};

}  // namespace

std::unique_ptr<ComparedEstimator> MakeOpenCvPpf(const ObjectModel& model) {
  return std::make_unique<OpenCvPpf>(model);
}

}  // namespace vantage
