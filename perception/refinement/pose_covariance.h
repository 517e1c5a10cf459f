#pragma once

#include "perception/refinement/motion_equations.h"
#include "perception/refinement/refinement_parameters.h"

namespace vantage {

/// Covariance of the error of a pose that solves `equations`: rotation vector (rad) and translation
/// of the center (m), in the camera's axes. Three things make it more than the inverse of the
/// information:
/// - neighboring pixels share most of their matching window, so that `correlated_px` of them tell
///   as much as one;
/// - normals of a mesh are off by some degrees, which makes directions look fixed that nothing
///   fixes, like the turn of a bottle. What so small slants would tell is taken off, and what is
///   left without information gets the variance of a radian and of `lever`;
/// - the sensor's bias is smooth over an object: it shifts and tilts the whole.
/// @param pixels_per_pair px of the image that one pair stands for.
/// @param lever m, typical distance of the surface from the center.
/// @param depth m, of the center.
Matrix6 PoseCovariance(const MotionEquations& equations,
                       double pixels_per_pair,
                       double lever,
                       double depth,
                       const RefinementParameters& parameters);

}  // namespace vantage
