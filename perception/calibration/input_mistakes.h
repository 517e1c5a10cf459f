#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "perception/calibration/hand_eye.h"
#include "perception/calibration/raw_pose.h"

namespace vantage {

/// How far views are from agreeing with each other: of the half that agrees best the farthest.
struct InputResidual {
  double rotation = std::numeric_limits<double>::infinity();     ///< rad
  double translation = std::numeric_limits<double>::infinity();  ///< m
  /// Both together, in radians and in lengths of the motion; below 0.1 the views agree.
  double relative = std::numeric_limits<double>::infinity();
};

/// Another way to read the input, under which it fits far better.
struct InputMistake {
  std::string cause;  ///< "the camera poses are inverted (...)"
  InputResidual residual;
};

/// What is wrong with poses as a whole.
struct InputDiagnosis {
  InputResidual as_given;  ///< infinite where a row is no pose
  /// Best first; more than one fit about as well. Empty where the reading that was given fits, or
  /// none does.
  std::vector<InputMistake> mistakes;
  std::vector<std::string> remarks;  ///< what is wrong whatever the reading, a sentence each
  /// What may be wrong although all fits together, a sentence each.
  std::vector<std::string> warnings;

  /// Nothing is wrong but what there may be warnings of.
  [[nodiscard]] bool IsSound() const;
  /// Sentences for people; empty where it is sound.
  [[nodiscard]] std::string Text() const;
};

/// What of the input people wrote down; what a detector measured is not in doubt.
enum class InputSource { kPosesAndPoses, kPosesAndImages };

/// Searches for a mistake that many make: inverted poses, the other setup, exchanged columns,
/// millimeters for meters, degrees for radians, quaternions in another order, transposed or
/// mirrored rotations, rows shifted by one; also two of them at once. Each reading is judged by the
/// views that agree best (FindConsensus()), so that outliers do no harm. Needs 4 views; of fewer
/// nothing is said. The same for the same seed.
InputDiagnosis DiagnoseInput(HandEyeSetup setup,
                             std::span<const RawView> views,
                             InputSource source,
                             uint64_t seed);

}  // namespace vantage
