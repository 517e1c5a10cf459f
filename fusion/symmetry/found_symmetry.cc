#include "fusion/symmetry/found_symmetry.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/check.h"
#include "common/format.h"

namespace vantage {
namespace {

using Axis = FoundSymmetry::Axis;

std::string Text(const Eigen::Vector3d& v) {
  // Adding 0 turns -0 into 0.
  const Eigen::Vector3d rounded = (1e4 * v).array().round() / 1e4;
  return Format("(%.4g, %.4g, %.4g)", rounded.x() + 0.0, rounded.y() + 0.0, rounded.z() + 0.0);
}

// Of both directions the one whose largest coordinate is positive.
Eigen::Vector3d Upward(const Eigen::Vector3d& axis) {
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  return axis[largest] < 0.0 ? Eigen::Vector3d(-axis) : axis;
}

std::string AxisText(const Axis& axis) {
  const std::string where = Text(axis.direction);
  if (axis.order == 0) {
    return Format(
        "axis        %s, every rotation, confidence %.2f\n", where.c_str(), axis.confidence);
  }
  return Format(
      "axis        %s, %d-fold, confidence %.2f\n", where.c_str(), axis.order, axis.confidence);
}

}  // namespace

std::vector<Axis> AxesOf(const SymmetryGroup& group, const std::vector<double>& confidence) {
  std::vector<Axis> axes;
  if (group.kind == SymmetryGroup::Kind::kContinuous) {
    VANTAGE_CHECK(confidence.size() == 2, "confidences of a continuous group");
    axes.push_back({group.axis, 0, confidence[0]});
    if (group.flips) axes.push_back({group.axis.unitOrthogonal(), 2, confidence[1]});
    return axes;
  }
  VANTAGE_CHECK(confidence.size() == group.elements.size(), "confidences of a finite group");
  constexpr double kSameAxis = 0.02;  // Sine of the angle between them.
  for (size_t i = 0; i < group.elements.size(); ++i) {
    const Eigen::Vector3d turn = LogSo3(group.elements[i]);
    if (turn.norm() < 1e-6) continue;
    const auto same = std::find_if(axes.begin(), axes.end(), [&](const Axis& axis) {
      return axis.direction.cross(turn.normalized()).norm() < kSameAxis;
    });
    if (same == axes.end()) {
      axes.push_back({Upward(turn.normalized()), 2, confidence[i]});
    } else {
      ++same->order;
      same->confidence = std::min(same->confidence, confidence[i]);
    }
  }
  std::stable_sort(
      axes.begin(), axes.end(), [](const Axis& a, const Axis& b) { return a.order > b.order; });
  return axes;
}

std::string FoundSymmetryText(const FoundSymmetry& found) {
  std::string text;
  if (found.is_sphere) {
    text +=
        "axis        any: every rotation is a symmetry; the orientation can't be told and "
        "needn't be\n";
  } else if (found.axes.empty()) {
    text += "axis        none\n";
  } else {
    for (const Axis& axis : found.axes) text += AxisText(axis);
  }
  text += Format("confidence  %.2f\n", found.confidence);
  for (const FoundSymmetry::Mirror& mirror : found.mirrors) {
    text += Format("mirror      plane with normal %s, off by %.2f %% of the diameter\n",
                   Text(mirror.normal).c_str(),
                   100.0 * mirror.residual);
  }
  for (const FoundSymmetry::Confusion& confusion : found.confusions) {
    const Eigen::Vector3d turn = LogSo3(confusion.rotation);
    text += Format(
        "confusion   %.0f degrees about %s, %.1f %% of the detections, seen from %.0f %% "
        "of the directions\n",
        turn.norm() / kDegree,
        Text(Upward(turn.normalized())).c_str(),
        100.0 * confusion.weight,
        100.0 * confusion.share_of_directions);
  }
  return text;
}

}  // namespace vantage
