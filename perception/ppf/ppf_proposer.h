#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <span>
#include <vector>

#include "common/rng.h"
#include "common/symmetry_group.h"
#include "perception/estimator/pose_proposer.h"
#include "perception/ppf/ppf_table.h"
#include "perception/ppf/ppf_voting.h"
#include "perception/ppf/silhouette.h"
#include "perception/ppf/surface_score.h"

namespace vantage {

/// Poses by geometric hashing (paper section 3.1; Drost et al. 2010): the peaks of a few reference
/// points' votes, of which the poses are kept that bring most scene points onto the model.
class PpfProposer : public PoseProposer {
 public:
  struct Model {
    PpfTable table;
    Eigen::Vector3d center;  ///< m, whose places decide how far two poses are apart
    SymmetryGroup symmetry;
  };
  PpfProposer(std::vector<Model> models, const PpfVotingParameters& parameters);

  [[nodiscard]] double Spacing(size_t model) const override;
  std::span<const PoseHypothesis> Propose(size_t model,
                                          std::span<const SurfacePoint> scene,
                                          Rng& rng) override;
  [[nodiscard]] std::unique_ptr<PoseProposer> Clone() const override {
    return std::make_unique<PpfProposer>(*this);
  }

 private:
  // A model beside what each of its points contributes to a pose.
  struct Prepared {
    Model model;
    SurfaceScore score;
    std::vector<Eigen::Isometry3f> T_aligned_object;  // AlignToXAxis of each point.
    SurfaceLanes outline;                             // Some of the points.
  };
  struct Candidate {
    Eigen::Isometry3f T_camera_object;
    float score;
    size_t number;  // Decides between equals.
  };

  void TakeScene(std::span<const SurfacePoint> scene, double spacing);
  void AddCandidates(const Prepared& prepared, size_t reference);
  [[nodiscard]] float Rate(const Prepared& prepared, const Eigen::Isometry3f& T) const;
  void Polish(const Prepared& prepared, Candidate* candidate) const;
  void KeepDistinct(const Prepared& prepared, size_t count);

  PpfVotingParameters parameters_;
  std::vector<Prepared> models_;
  // Reused.
  PpfVoting voting_;
  SurfaceLanes scene_;
  Silhouette silhouette_;
  SurfaceLanes probes_;  // Of the scene, on which poses are scored.
  std::vector<Candidate> candidates_;
  std::vector<Candidate> distinct_;
  std::vector<PoseHypothesis> hypotheses_;
};

}  // namespace vantage
