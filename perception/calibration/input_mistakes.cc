#include "perception/calibration/input_mistakes.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "common/format.h"
#include "common/statistics.h"
#include "perception/calibration/closed_form.h"
#include "perception/calibration/consensus.h"

namespace vantage {
namespace {

constexpr size_t kFewestViews = 4;
constexpr size_t kMostViews = 40;         // Of a larger set some, evenly.
constexpr double kAgreement = 0.1;        // Largest relative residual of a reading that fits.
constexpr double kContradiction = 0.2;    // From here on the views say nothing in common.
constexpr double kByFar = 5.0;            // Residual as given by that of a mend.
constexpr double kAboutAsWell = 2.0;      // Residual of a mend by that of the best one.
constexpr double kFloor = 2e-3;           // Relative residual below which differences are noise.
constexpr double kLargestMotion = 20.0;   // m, of any arm
constexpr double kFarthestTarget = 50.0;  // m, from the camera

enum class Mirror { kNone, kFrames, kAxis, kBase };

// What is undone to one column of poses.
struct ColumnReading {
  bool millimeters = false;
  bool degrees = false;
  int quaternion_turn = 0;  // Places by which w, x, y, z are moved to the left.
  bool transposed = false;
  Mirror mirror = Mirror::kNone;

  [[nodiscard]] bool AppliesTo(const RawPose& raw) const {
    return (!degrees || raw.kind == RawPose::Rotation::kRotationVector) &&
           (quaternion_turn == 0 || raw.kind == RawPose::Rotation::kQuaternion) &&
           ((mirror != Mirror::kAxis && mirror != Mirror::kBase) ||
            raw.kind == RawPose::Rotation::kMatrix);
  }
};

struct Reading {
  std::string cause = {};  // Without that of `inverted`.
  ColumnReading hand = {};
  ColumnReading camera = {};
  // The camera's poses, which is the same in effect as the robot's, and as the other setup: A X B =
  // Y is A^-1 Y B^-1 = X.
  bool inverted = false;
  int shift = 0;  // Of rows: the camera pose of row i belongs to the hand pose of row i + shift.
};

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

std::optional<Pose> ReadPose(RawPose raw, const ColumnReading& reading) {
  const Eigen::Vector3d mirror(1.0, 1.0, -1.0);
  if (reading.millimeters) raw.translation *= 1e-3;
  if (reading.degrees) {
    for (int i = 0; i < 3; ++i) raw.rotation[static_cast<size_t>(i)] *= kDegree;
  }
  if (reading.quaternion_turn != 0) {
    std::rotate(raw.rotation.begin(),
                raw.rotation.begin() + reading.quaternion_turn,
                raw.rotation.begin() + 4);
  }
  Eigen::Map<RowMajor3> matrix(raw.rotation.data());
  if (reading.mirror == Mirror::kAxis) matrix = matrix * mirror.asDiagonal();
  if (reading.mirror == Mirror::kBase) {
    matrix = mirror.asDiagonal() * matrix;
    raw.translation = raw.translation.cwiseProduct(mirror);
  }
  const Result<Pose> read = PoseFromRaw(raw);
  if (!read) return std::nullopt;
  Pose pose = *read;
  if (reading.transposed) pose.linear() = read->linear().transpose();
  if (reading.mirror == Mirror::kFrames) {
    pose.linear() = mirror.asDiagonal() * read->linear() * mirror.asDiagonal();
    pose.translation() = pose.translation().cwiseProduct(mirror);
  }
  return pose;
}

// Empty where a row is no pose.
std::vector<PoseView> Read(std::span<const RawView> views, const Reading& reading) {
  std::vector<PoseView> read;
  const auto n = static_cast<int>(views.size());
  for (int i = 0; i < n; ++i) {
    const int j = i + reading.shift;
    if (j < 0 || j >= n) continue;
    const auto hand = ReadPose(views[static_cast<size_t>(j)].hand, reading.hand);
    const auto camera = ReadPose(views[static_cast<size_t>(i)].camera, reading.camera);
    if (!hand || !camera) return {};
    read.push_back({.name = {},
                    .T_base_hand = *hand,
                    .T_camera_target = reading.inverted ? camera->inverse() : *camera});
  }
  if (read.size() <= kMostViews) return read;
  std::vector<PoseView> some;
  for (size_t k = 0; k < kMostViews; ++k) some.push_back(read[k * read.size() / kMostViews]);
  return some;
}

// m, typical distance from the middle, whatever a few outliers say.
double Spread(std::span<const Eigen::Vector3d> points) {
  Eigen::Vector3d middle;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Eigen::Vector3d& point : points) values.push_back(point[axis]);
    middle[axis] = Median(values);
  }
  std::vector<double> distances;
  for (const Eigen::Vector3d& point : points) distances.push_back((point - middle).norm());
  return Median(distances);
}

struct Extent {
  double hand = 0.0;      // m, Spread()
  double camera = 0.0;    // m, Spread()
  double distance = 0.0;  // m, of the target from the camera

  // m, what residuals are held against. Poses that are all the same shall agree.
  [[nodiscard]] double Length() const { return std::max({hand, camera, 0.05 * distance, 1e-9}); }
};

Extent Measure(std::span<const PoseView> views) {
  std::vector<Eigen::Vector3d> hands;
  std::vector<Eigen::Vector3d> targets;
  std::vector<double> distances;
  for (const PoseView& view : views) {
    hands.emplace_back(view.T_base_hand.translation());
    targets.emplace_back(view.T_camera_target.translation());
    distances.push_back(targets.back().norm());
  }
  return {Spread(hands), Spread(targets), Median(distances)};
}

InputResidual Residual(HandEyeSetup setup, std::span<const PoseView> views, uint64_t seed) {
  if (views.size() < kFewestViews) return {};
  const double length = Measure(views).Length();
  constexpr double kSigma = 0.005;  // rad; only the ratio of both counts.
  HandEyeNoise noise;
  noise.robot_rotation = noise.robot_translation = 0.0;
  noise.camera_rotation = kSigma;
  noise.camera_translation = kSigma * length;
  const Result<Consensus> consensus = FindConsensus(setup, views, noise, seed);
  if (!consensus) return {};
  std::vector<double> rotations;
  std::vector<double> translations;
  std::vector<double> relative;
  for (const PoseView& view : views) {
    const Pose found =
        EquationOfHand(setup, view.T_base_hand) * consensus->T_x * view.T_camera_target;
    rotations.push_back(GeodesicAngle(Eigen::Quaterniond(found.linear()),
                                      Eigen::Quaterniond(consensus->T_y.linear())));
    translations.push_back((found.translation() - consensus->T_y.translation()).norm());
    relative.push_back(std::hypot(rotations.back(), translations.back() / length));
  }
  // As many as FindConsensus() lets decide.
  const size_t core = std::min(views.size(), (views.size() + 3) / 2) - 1;
  const auto of_core = [core](std::vector<double>& values) {
    std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(core));
    return values[core];
  };
  return {of_core(rotations), of_core(translations), of_core(relative)};
}

// Share of the views in which the target is in front of the camera, rather along z than beside it.
double ShareInFront(std::span<const PoseView> views, const auto& T_camera_target) {
  size_t in_front = 0;
  for (const PoseView& view : views) {
    const Eigen::Vector3d t = T_camera_target(view).translation();
    if (t.z() > 0.5 * t.norm()) ++in_front;
  }
  return static_cast<double>(in_front) / static_cast<double>(views.size());
}

Pose GivenTarget(const PoseView& view) { return view.T_camera_target; }
Pose InvertedTarget(const PoseView& view) { return view.T_camera_target.inverse(); }

// Which of the things that are the same in effect it is: a camera sees what is in front of it.
std::string DirectionCause(HandEyeSetup setup,
                           InputSource source,
                           std::span<const PoseView> views) {
  const std::string robot = Format(
      "the robot poses are inverted (T_hand_base was given, T_base_hand is expected), or the "
      "camera %s with the hand: then say --setup %s",
      setup == HandEyeSetup::kEyeInHand ? "does not move" : "moves",
      setup == HandEyeSetup::kEyeInHand ? "eye-to-hand" : "eye-in-hand");
  const char* camera =
      "the camera poses are inverted (T_target_camera was given, T_camera_target is expected)";
  if (source == InputSource::kPosesAndImages) return robot;
  constexpr double kMost = 0.9;
  const bool as_given = ShareInFront(views, GivenTarget) > kMost;
  const bool inverted = ShareInFront(views, InvertedTarget) > kMost;
  if (as_given && !inverted) return robot;
  if (inverted && !as_given) return camera;
  return Format("%s, or %s", camera, robot.c_str());
}

struct ColumnMistake {
  const char* cause;
  ColumnReading reading;
  bool may_be_of_both;  // Where both have it, the views may contradict each other.
};

const std::vector<ColumnMistake>& ColumnMistakes() {
  static const std::vector<ColumnMistake> mistakes = {
      {"translations are in millimeters (meters are expected)", {.millimeters = true}, false},
      {"rotation vectors are in degrees (radians are expected)", {.degrees = true}, true},
      {"quaternions are in the order x, y, z, w where w, x, y, z is expected",
       {.quaternion_turn = 3},
       true},
      {"quaternions are in the order w, x, y, z where x, y, z, w is expected",
       {.quaternion_turn = 1},
       true},
      {"rotations are transposed (column by column, or turning the other way)",
       {.transposed = true},
       true},
      {"axes are left-handed (one axis must be turned round)", {.mirror = Mirror::kFrames}, false},
      {"matrices mirror: one axis of what they place must be turned round",
       {.mirror = Mirror::kAxis},
       true},
      {"matrices mirror: one axis of what they are given in must be turned round",
       {.mirror = Mirror::kBase},
       true},
  };
  return mistakes;
}

// What may be done wrong, one thing each.
std::vector<Reading> SingleMistakes(std::span<const RawView> views, InputSource source) {
  std::vector<Reading> readings = {{.inverted = true}};
  const bool both_written = source == InputSource::kPosesAndPoses;
  for (const ColumnMistake& mistake : ColumnMistakes()) {
    const ColumnReading& reading = mistake.reading;
    const bool of_hand = std::ranges::all_of(
        views, [&](const RawView& view) { return reading.AppliesTo(view.hand); });
    const bool of_camera = both_written && std::ranges::all_of(views, [&](const RawView& view) {
                             return reading.AppliesTo(view.camera);
                           });
    if (of_hand) readings.push_back({Format("the robot's %s", mistake.cause), reading, {}});
    if (of_camera) readings.push_back({Format("the camera's %s", mistake.cause), {}, reading});
    if (of_hand && of_camera && mistake.may_be_of_both) {
      readings.push_back(
          {Format("the robot's and the camera's %s", mistake.cause), reading, reading});
    }
  }
  const char* what = both_written ? "camera pose" : "image";
  readings.push_back(
      {.cause = Format("every %s belongs to the robot pose one row later", what), .shift = 1});
  readings.push_back(
      {.cause = Format("every %s belongs to the robot pose one row earlier", what), .shift = -1});
  return readings;
}

ColumnReading Together(const ColumnReading& a, const ColumnReading& b) {
  return {.millimeters = a.millimeters || b.millimeters,
          .degrees = a.degrees || b.degrees,
          .quaternion_turn = std::max(a.quaternion_turn, b.quaternion_turn),
          .transposed = a.transposed || b.transposed,
          .mirror = a.mirror == Mirror::kNone ? b.mirror : a.mirror};
}

// Two at once; not those that undo each other. The inverted one comes first.
std::vector<Reading> DoubleMistakes(const std::vector<Reading>& singles) {
  std::vector<Reading> readings;
  for (size_t i = 0; i < singles.size(); ++i) {
    for (size_t j = i + 1; j < singles.size(); ++j) {
      const Reading& a = singles[i];
      const Reading& b = singles[j];
      const auto clash = [](const ColumnReading& x, const ColumnReading& y) {
        return (x.quaternion_turn != 0 && y.quaternion_turn != 0) ||
               (x.transposed && y.transposed) ||
               (x.mirror != Mirror::kNone && y.mirror != Mirror::kNone) || (x.degrees && y.degrees);
      };
      if (clash(a.hand, b.hand) || clash(a.camera, b.camera)) continue;
      if (a.shift != 0 && b.shift != 0) continue;
      if ((a.hand.transposed || a.camera.transposed) &&
          (b.hand.transposed || b.camera.transposed)) {
        continue;
      }
      readings.push_back({.cause = a.cause.empty()
                                       ? b.cause
                                       : Format("%s, and %s", a.cause.c_str(), b.cause.c_str()),
                          .hand = Together(a.hand, b.hand),
                          .camera = Together(a.camera, b.camera),
                          .inverted = a.inverted,
                          .shift = a.shift + b.shift});
    }
  }
  return readings;
}

// Those by which the residual drops by far, best first.
std::vector<InputMistake> Mends(HandEyeSetup setup,
                                std::span<const RawView> views,
                                InputSource source,
                                const std::vector<Reading>& readings,
                                const InputResidual& as_given,
                                uint64_t seed) {
  std::vector<InputMistake> mends;
  for (const Reading& reading : readings) {
    const std::vector<PoseView> read = Read(views, reading);
    const InputResidual residual = Residual(setup, read, seed);
    const double relative = std::max(residual.relative, kFloor);
    if (relative > kAgreement || relative * kByFar > as_given.relative) continue;
    std::string cause = reading.cause;
    if (reading.inverted) {
      Reading straight = reading;
      straight.inverted = false;
      const std::string direction = DirectionCause(setup, source, Read(views, straight));
      cause = cause.empty() ? direction : Format("%s, and %s", cause.c_str(), direction.c_str());
    }
    mends.push_back({cause, residual});
  }
  std::ranges::stable_sort(
      mends, {}, [](const InputMistake& mend) { return mend.residual.relative; });
  if (mends.empty()) return mends;
  const double best = std::max(mends.front().residual.relative, kFloor);
  std::erase_if(mends, [best](const InputMistake& mend) {
    return mend.residual.relative > kAboutAsWell * best;
  });
  return mends;
}

std::vector<std::string> Remarks(std::span<const PoseView> views) {
  constexpr double kSame = 1e-9;  // m, rad
  std::vector<std::string> remarks;
  const auto all_same = [&](const auto& pose_of) {
    return std::ranges::all_of(views, [&](const PoseView& view) {
      return pose_of(view).isApprox(pose_of(views.front()), kSame);
    });
  };
  const bool same_hand = all_same([](const PoseView& view) { return view.T_base_hand; });
  const bool same_camera = all_same([](const PoseView& view) { return view.T_camera_target; });
  if (same_hand) {
    remarks.emplace_back("the robot poses are all the same: move the arm between the views");
  } else if (same_camera) {
    remarks.emplace_back(
        "the camera poses are all the same although the robot moved: are they of one image?");
  }
  const Extent extent = Measure(views);
  if (extent.hand > kLargestMotion) {
    remarks.push_back(
        Format("the robot's hand is typically %.0f m from the middle of its poses: millimeters for "
               "meters?",
               extent.hand));
  }
  if (extent.distance > kFarthestTarget) {
    remarks.push_back(
        Format("the target is typically %.0f m away from the camera: millimeters for "
               "meters?",
               extent.distance));
  }
  return remarks;
}

// What fits all the same: A X B = Y is A^-1 Y B^-1 = X, and B Y^-1 A = X^-1.
std::vector<std::string> Warnings(std::span<const PoseView> views, InputSource source) {
  constexpr double kFew = 0.5;
  constexpr double kMost = 0.9;
  const double share = ShareInFront(views, GivenTarget);
  if (source == InputSource::kPosesAndImages || share > kFew) return {};
  const bool inverted = ShareInFront(views, InvertedTarget) > kMost;
  const bool exchanged =
      ShareInFront(views, [](const PoseView& view) { return view.T_base_hand; }) > kMost;
  const char* guess = inverted && exchanged
                          ? ": are robot and camera poses exchanged, or both inverted?"
                      : inverted  ? ": are robot and camera poses both inverted?"
                      : exchanged ? ": are robot and camera poses exchanged?"
                                  : "";
  return {
      Format("in %.0f %% of the views the target is not in front of the camera, along its z "
             "axis, although the poses fit together%s",
             100.0 * (1.0 - share),
             guess)};
}

std::string ResidualText(const InputResidual& residual) {
  return Format("%.3g mm, %.3g deg", 1e3 * residual.translation, residual.rotation / kDegree);
}

}  // namespace

bool InputDiagnosis::IsSound() const {
  return mistakes.empty() && remarks.empty() && as_given.relative <= kContradiction;
}

std::string InputDiagnosis::Text() const {
  if (IsSound()) return "";
  std::string text;
  for (const std::string& remark : remarks) {
    text += text.empty() ? "" : "; ";
    text += remark;
  }
  if (!mistakes.empty()) {
    text += text.empty() ? "" : "; ";
    const std::string after = ResidualText(mistakes.front().residual);
    text +=
        std::isfinite(as_given.relative)
            ? Format(
                  "residual drops from %s to %s if ", ResidualText(as_given).c_str(), after.c_str())
            : Format("not all rows are poses as they were read; the residual is %s if ",
                     after.c_str());
    for (size_t i = 0; i < mistakes.size(); ++i) {
      text += i == 0 ? "" : "; or, about as well, if ";
      text += mistakes[i].cause;
    }
  } else if (remarks.empty() && std::isfinite(as_given.relative)) {
    text += Format(
        "the views contradict each other: even those that agree best differ by %s, and "
        "no other reading of the numbers explains them",
        ResidualText(as_given).c_str());
  }
  return text;
}

InputDiagnosis DiagnoseInput(HandEyeSetup setup,
                             std::span<const RawView> views,
                             InputSource source,
                             uint64_t seed) {
  InputDiagnosis diagnosis;
  if (views.size() < kFewestViews) {
    diagnosis.as_given = {0.0, 0.0, 0.0};
    return diagnosis;
  }
  const std::vector<PoseView> given = Read(views, {});
  diagnosis.as_given = Residual(setup, given, seed);
  if (!given.empty()) diagnosis.remarks = Remarks(given);
  if (diagnosis.as_given.relative <= kAgreement) diagnosis.warnings = Warnings(given, source);
  if (diagnosis.as_given.relative <= kByFar * kFloor) return diagnosis;
  const std::vector<Reading> singles = SingleMistakes(views, source);
  diagnosis.mistakes = Mends(setup, views, source, singles, diagnosis.as_given, seed);
  if (diagnosis.mistakes.empty() && diagnosis.as_given.relative > kAgreement) {
    diagnosis.mistakes =
        Mends(setup, views, source, DoubleMistakes(singles), diagnosis.as_given, seed);
  }
  return diagnosis;
}

}  // namespace vantage
