#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "perception/calibration/reprojection_adjustment.h"

namespace vantage {

/// What all views say of what they share, their own poses marginalized.
struct SharedEquations {
  Eigen::MatrixXd information;           ///< with what is there before any view
  Eigen::MatrixXd covariance;            ///< its inverse; very large where nothing is known
  std::vector<Eigen::MatrixXd> of_view;  ///< each view's part of the information
  std::vector<Eigen::VectorXd> gradient_of_view;
};

/// @param prior diagonal, PriorInformation().
SharedEquations ShareEquations(std::span<const ViewEquations> views,
                               const ReprojectionNoise& noise,
                               const Eigen::VectorXd& prior);

/// Noise of points and robot as the residuals say, and on how many degrees of freedom each rests.
struct NoiseEstimate {
  ReprojectionNoise noise;
  double pixel_freedom = 0.0;
  double rotation_freedom = 0.0;
  double translation_freedom = 0.0;
};

/// One step of the iterated estimate of variance components: each group's sum of squares by its
/// share of the redundancy (Foerstner, "Ein Verfahren zur Schaetzung von Varianz- und
/// Kovarianzkomponenten", AVN 1979; Koch, "Parameter Estimation and Hypothesis Testing in Linear
/// Models", 1999, section 3.6). Where views are few, the robot's rotation and translation keep
/// about the ratio that was told.
NoiseEstimate EstimateNoise(std::span<const ViewEquations> views,
                            const ReprojectionNoise& told,
                            const ReprojectionNoise& current,
                            const Eigen::VectorXd& prior);

/// Degrees of freedom that X's covariance rests on (Satterthwaite, "An Approximate Distribution of
/// Estimates of Variance Components", 1946): those of the components, by their shares in it.
double EffectiveFreedom(std::span<const ViewEquations> views,
                        const NoiseEstimate& estimate,
                        const Eigen::VectorXd& prior);

}  // namespace vantage
