#pragma once

#include <optional>
#include <span>

#include "perception/calibration/hand_eye.h"

namespace vantage {

/// X and Y of A X B = Y.
struct HandEyeTransforms {
  Pose T_x = Pose::Identity();
  Pose T_y = Pose::Identity();
};

/// What one view says of them.
struct HandEyeEquation {
  Pose A = Pose::Identity();
  Pose B = Pose::Identity();
};

/// A of hand_eye.h.
Pose EquationOfHand(HandEyeSetup setup, const Pose& T_base_hand);

/// A way to solve without a start. Nothing for fewer than 3 equations and where the result is not
/// finite. What the motions leave open is taken as some value, a translation as small as can be.
using ClosedFormSolver = std::optional<HandEyeTransforms> (*)(std::span<const HandEyeEquation>);

/// Rotation of X from the logarithms of all relative motions (Park, Martin, "Robot Sensor
/// Calibration: Solving AX = XB on the Euclidean Group", 1994, Eq. 14), then the translations.
/// Where all rotations are about one axis or there are none, the translations tell the rest of the
/// rotation as far as they can.
std::optional<HandEyeTransforms> SolvePark(std::span<const HandEyeEquation> equations);

/// Rotation of X from dual quaternions of all relative motions, which also heed their translations
/// (Daniilidis, "Hand-Eye Calibration Using Dual Quaternions", 1999, section 5), then the
/// translations.
std::optional<HandEyeTransforms> SolveDaniilidis(std::span<const HandEyeEquation> equations);

/// Rotations of X and Y together from Kronecker products (Shah, "Solving the Robot-World/Hand-Eye
/// Calibration Problem Using the Kronecker Product", 2013, section 3), then the translations. Needs
/// no logarithms, which are ambiguous near half a turn.
std::optional<HandEyeTransforms> SolveShah(std::span<const HandEyeEquation> equations);

struct ClosedForm {
  const char* name;
  ClosedFormSolver solve;
};

/// All of them.
std::span<const ClosedForm> ClosedForms();

}  // namespace vantage
