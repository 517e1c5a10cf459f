#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "common/result.h"
#include "perception/estimator/pose_proposer.h"
#include "perception/model/object_model.h"
#include "perception/refinement/nearest_grid.h"
#include "perception/shot/correspondence_ransac.h"
#include "perception/shot/shot_features.h"
#include "perception/shot/shot_model.h"
#include "perception/shot/shot_parameters.h"

namespace vantage {

/// Seconds that the steps of a call took, by the caller's clock.
struct ShotTimes {
  std::function<double()> clock;  ///< s
  double keypoints = 0.0;
  double features = 0.0;
  double matching = 0.0;
  double ransac = 0.0;
  double ranking = 0.0;
};

/// Poses from correspondences of local features (paper section 3.2, fig. 2): keypoints, SHOT
/// descriptors, k nearest neighbors, RANSAC; then ranked by how many of the scene's points lie on
/// the model. ICP and verification are left to the caller. Unlike other proposers it allocates in
/// every call: PCL does (ShotFeatures), and the ranking a little.
class ShotProposer : public PoseProposer {
 public:
  /// Trains the models: 0.4 to 0.7 s each. Errors: parameters, a model that can't be trained.
  static Result<std::unique_ptr<ShotProposer>> Create(std::span<const ObjectModel> models,
                                                      const ShotParameters& parameters);

  [[nodiscard]] double Spacing(size_t model) const override;
  std::span<const PoseHypothesis> Propose(size_t model,
                                          std::span<const SurfacePoint> scene,
                                          Rng& rng) override;
  [[nodiscard]] std::unique_ptr<PoseProposer> Clone() const override;
  /// The same, and how long it took. @param times may be null.
  std::span<const PoseHypothesis> Propose(size_t model,
                                          std::span<const SurfacePoint> scene,
                                          Rng& rng,
                                          ShotTimes* times);

 private:
  struct Model {
    ShotModel shot;
    NearestGrid surface;
    SymmetryGroup symmetry;
    Eigen::Vector3d center;  // m
    RansacParameters ransac;
  };
  explicit ShotProposer(const ShotParameters& parameters) : parameters_(parameters) {}
  void Rank(const Model& model, std::span<const ConsensusPose> poses);

  ShotParameters parameters_;
  std::vector<Model> models_;
  ShotFeatures features_;
  CorrespondenceRansac ransac_;
  std::vector<SurfacePoint> scene_;  // Those of it that are finite.
  std::vector<uint32_t> keypoints_;
  std::vector<Correspondence> correspondences_;
  std::vector<PoseHypothesis> ranked_;
  std::vector<PoseHypothesis> hypotheses_;
};

}  // namespace vantage
