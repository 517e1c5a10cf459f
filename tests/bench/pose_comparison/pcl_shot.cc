// Correspondences of SHOT descriptors (Tombari et al. 2010) of the Point Cloud Library 1.13,
// aligned by pcl::SampleConsensusPrerejective (Buch et al. 2013) or
// pcl::SampleConsensusInitialAlignment (SAC-IA, Rusu et al. 2009), then ICP. The scene is aligned
// to the model: nearly all of the scene has its place on the model, but not the other way round.
#include <pcl/features/shot.h>
#include <pcl/registration/ia_ransac.h>
#include <pcl/registration/sample_consensus_prerejective.h>

#include <cstdlib>

#include "tests/bench/pose_comparison/compared_estimator.h"
#include "tests/bench/pose_comparison/pcl_clouds.h"

namespace vantage {
namespace {

// Lengths are relative to the diameter.
constexpr double kSampling = 0.04;        // Of model and scene.
constexpr double kNormalSampling = 0.02;  // Of the cloud on which normals are estimated.
constexpr double kNormalRadius = 0.06;    // About a point.
constexpr double kShotRadius = 0.2;       // Of descriptor and reference frame.
constexpr double kIcpModelSampling = 0.02;
constexpr double kInlierDistance = 0.06;  // 1.5 samplings, as the library's tutorial has it.
constexpr int kSamples = 3;
constexpr int kCorrespondences = 5;  // Best ones of a point, of which one is drawn.

constexpr int kPrerejectiveIterations = 50000;  // These as in the library's tutorial.
constexpr float kSimilarity = 0.9F;
constexpr float kInlierFraction = 0.25F;

constexpr int kSacIaIterations = 500;
constexpr double kSampleDistance = 0.1;  // Between the points of a sample.

using Descriptors = pcl::PointCloud<pcl::SHOT352>;

// A cloud, and descriptors of its points; points without one are left out.
struct DescribedSurface {
  PclSurface::Ptr surface{new PclSurface};
  Descriptors::Ptr descriptors{new Descriptors};
};

DescribedSurface Describe(const PclSurface::Ptr& surface, double radius) {
  pcl::SHOTEstimation<pcl::PointNormal, pcl::PointNormal, pcl::SHOT352> estimation;
  estimation.setInputCloud(surface);
  estimation.setInputNormals(surface);
  estimation.setRadiusSearch(radius);
  Descriptors all;
  estimation.compute(all);
  DescribedSurface described;
  for (size_t i = 0; i < all.size(); ++i) {
    if (!std::isfinite(all[i].descriptor[0])) continue;
    described.surface->push_back((*surface)[i]);
    described.descriptors->push_back(all[i]);
  }
  return described;
}

using Prerejective =
    pcl::SampleConsensusPrerejective<pcl::PointNormal, pcl::PointNormal, pcl::SHOT352>;
using SacIa =
    pcl::SampleConsensusInitialAlignment<pcl::PointNormal, pcl::PointNormal, pcl::SHOT352>;

void Configure(double diameter, Prerejective* alignment) {
  alignment->setMaximumIterations(kPrerejectiveIterations);
  alignment->setSimilarityThreshold(kSimilarity);
  alignment->setInlierFraction(kInlierFraction);
  alignment->setMaxCorrespondenceDistance(kInlierDistance * diameter);
}

void Configure(double diameter, SacIa* alignment) {
  alignment->setMaximumIterations(kSacIaIterations);
  alignment->setMinSampleDistance(static_cast<float>(kSampleDistance * diameter));
  alignment->setMaxCorrespondenceDistance(kInlierDistance * diameter);
}

template <class Alignment>
class PclShot : public ComparedEstimator {
 public:
  explicit PclShot(const ObjectModel& model)
      : diameter_(model.diameter),
        model_(Describe(ModelSurface(model, kSampling), kShotRadius * model.diameter)),
        icp_model_(ModelSurface(model, kIcpModelSampling)) {
    SilencePcl();
    alignment_.setInputTarget(model_.surface);
    alignment_.setTargetFeatures(model_.descriptors);
    alignment_.setNumberOfSamples(kSamples);
    alignment_.setCorrespondenceRandomness(kCorrespondences);
  }

  std::optional<Pose> Estimate(const SegmentedView& view, StageClock* stages) override {
    std::srand(1);  // Both alignments draw from rand().
    stages->Begin("preparation");
    const PclSurface::Ptr surface = SceneSurface(
        view.points, kSampling * diameter_, kNormalSampling * diameter_, kNormalRadius * diameter_);
    stages->Begin("descriptors");
    const DescribedSurface scene = Describe(surface, kShotRadius * diameter_);
    if (scene.surface->size() < kSamples) return std::nullopt;
    stages->Begin("matching");
    Configure(diameter_, &alignment_);
    alignment_.setInputSource(scene.surface);
    alignment_.setSourceFeatures(scene.descriptors);
    PclSurface aligned;
    alignment_.align(aligned);
    if (!alignment_.hasConverged()) return std::nullopt;
    const Eigen::Matrix4d T_object_camera =
        alignment_.getFinalTransformation().template cast<double>();
    if (!T_object_camera.allFinite()) return std::nullopt;
    stages->Begin("icp");
    return RefineWithIcp(scene.surface, icp_model_, Pose(T_object_camera).inverse(), diameter_);
  }

 private:
  double diameter_;
  DescribedSurface model_;
  PclSurface::Ptr icp_model_;
  Alignment alignment_;
};

}  // namespace

std::unique_ptr<ComparedEstimator> MakePclPrerejective(const ObjectModel& model) {
  return std::make_unique<PclShot<Prerejective>>(model);
}

std::unique_ptr<ComparedEstimator> MakePclSacIa(const ObjectModel& model) {
  return std::make_unique<PclShot<SacIa>>(model);
}

}  // namespace vantage
