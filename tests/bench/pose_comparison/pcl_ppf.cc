// Point pair features of the Point Cloud Library 1.13 (pcl::PPFRegistration), with ICP.
#include <pcl/features/ppf.h>
#include <pcl/registration/ppf_registration.h>

#include "tests/bench/pose_comparison/compared_estimator.h"
#include "tests/bench/pose_comparison/pcl_clouds.h"

namespace vantage {
namespace {

// Lengths are relative to the diameter.
// Drost et al. 2010 have 0.05, with which the mug takes 176 s to train and flat objects seconds a
// view.
constexpr double kFineSampling = 0.06;  // Of model and scene.
constexpr double kCoarseSampling = 0.08;
constexpr double kDistanceStep = 0.05;      // Of the feature, as they have it.
constexpr double kNormalSampling = 0.02;    // Of the cloud on which normals are estimated.
constexpr double kNormalRadius = 0.06;      // About a point.
constexpr double kClusterDistance = 0.1;    // Of poses that are averaged.
constexpr float kClusterAngle = 0.35F;      // rad; the library's default of 20 degrees.
constexpr unsigned int kReferenceRate = 5;  // Every fifth scene point; the library's default.
constexpr double kIcpModelSampling = 0.02;
// About 12 degrees, as Drost et al. have it. The library rounds a vote at pi up into a step behind
// the last one, which has no memory of its own: with 31 steps, and a little less each so that they
// are not counted as 30, that place is padding of the allocator.
constexpr double kAngleSteps = 31.0001;

using Registration = pcl::PPFRegistration<pcl::PointNormal, pcl::PointNormal>;

class PclPpf : public ComparedEstimator {
 public:
  PclPpf(const ObjectModel& model, double sampling)
      : diameter_(model.diameter),
        sampling_(sampling),
        model_(ModelSurface(model, sampling)),
        icp_model_(ModelSurface(model, kIcpModelSampling)) {
    SilencePcl();
    const pcl::PointCloud<pcl::PPFSignature>::Ptr features(new pcl::PointCloud<pcl::PPFSignature>);
    pcl::PPFEstimation<pcl::PointNormal, pcl::PointNormal, pcl::PPFSignature> estimation;
    estimation.setInputCloud(model_);
    estimation.setInputNormals(model_);
    estimation.compute(*features);
    search_.reset(new pcl::PPFHashMapSearch(static_cast<float>(2.0 * M_PI / kAngleSteps),
                                            static_cast<float>(kDistanceStep * diameter_)));
    search_->setInputFeatureCloud(features);
  }

  std::optional<Pose> Estimate(const SegmentedView& view, StageClock* stages) override {
    stages->Begin("preparation");
    const PclSurface::Ptr scene = SceneSurface(
        view.points, sampling_ * diameter_, kNormalSampling * diameter_, kNormalRadius * diameter_);
    if (scene->empty()) return std::nullopt;
    stages->Begin("matching");
    Registration registration;
    registration.setSceneReferencePointSamplingRate(kReferenceRate);
    registration.setPositionClusteringThreshold(static_cast<float>(kClusterDistance * diameter_));
    registration.setRotationClusteringThreshold(kClusterAngle);
    registration.setSearchMethod(search_);
    registration.setInputSource(model_);
    registration.setInputTarget(scene);
    PclSurface aligned;
    registration.align(aligned);
    const Pose coarse(registration.getFinalTransformation().cast<double>());
    if (!coarse.matrix().allFinite()) return std::nullopt;
    stages->Begin("icp");
    const Pose refined = RefineWithIcp(scene, icp_model_, coarse, diameter_);
    stages->End();
    return refined;
  }

 private:
  double diameter_;
  double sampling_;
  PclSurface::Ptr model_;
  PclSurface::Ptr icp_model_;
  pcl::PPFHashMapSearch::Ptr search_;
};

}  // namespace

std::unique_ptr<ComparedEstimator> MakePclPpf(const ObjectModel& model) {
  return std::make_unique<PclPpf>(model, kCoarseSampling);
}

std::unique_ptr<ComparedEstimator> MakePclPpfFine(const ObjectModel& model) {
  return std::make_unique<PclPpf>(model, kFineSampling);
}

}  // namespace vantage
