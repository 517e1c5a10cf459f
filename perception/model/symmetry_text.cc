#include "perception/model/symmetry_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "common/format.h"
#include "common/so3.h"

namespace vantage {
namespace {

using Kind = SymmetryDescription::Kind;

constexpr int kLargestOrder = 1000;
constexpr double kSameElement = 1e-6;  // rad
constexpr double kSameAxis = 1e-6;     // Sine of the angle between them.

// True when both list the same rotations, whatever the order.
bool SameElements(const SymmetryGroup& a, const SymmetryGroup& b) {
  if (a.elements.size() != b.elements.size()) return false;
  return std::all_of(a.elements.begin(), a.elements.end(), [&b](const Eigen::Quaterniond& wanted) {
    return std::any_of(
        b.elements.begin(), b.elements.end(), [&wanted](const Eigen::Quaterniond& element) {
          return GeodesicAngle(wanted, element) < kSameElement;
        });
  });
}

// The axis of some element that is not the identity.
Eigen::Vector3d AxisOf(const Eigen::Quaterniond& q) { return Canonical(q).vec().normalized(); }

// The axis about which a finite group of more than one element may be cyclic or dihedral: the one
// it names, or of its smallest turn.
Eigen::Vector3d MainAxis(const SymmetryGroup& group) {
  const auto turn = [](const Eigen::Quaterniond& q) { return std::abs(q.w()); };
  const auto is_about_axis = [&](const Eigen::Quaterniond& q) {
    return AxisOf(q).cross(group.axis).norm() < kSameAxis;
  };
  const auto smallest = std::max_element(
      group.elements.begin() + 1,
      group.elements.end(),
      [&](const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
        return turn(a) + 1e-6 * is_about_axis(a) < turn(b) + 1e-6 * is_about_axis(b);
      });
  if (is_about_axis(*smallest)) return group.axis;
  // Of both directions the one whose largest coordinate is positive.
  const Eigen::Vector3d axis = AxisOf(*smallest);
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  return axis[largest] < 0.0 ? Eigen::Vector3d(-axis) : axis;
}

// Axis of a half turn perpendicular to another axis; z where there is none.
Eigen::Vector3d HalfTurnAxis(const SymmetryGroup& group, const Eigen::Vector3d& axis) {
  for (const Eigen::Quaterniond& element : group.elements) {
    if (std::abs(element.w()) > kSameAxis) continue;
    if (std::abs(AxisOf(element).dot(axis)) < kSameAxis) return AxisOf(element);
  }
  return Eigen::Vector3d::UnitZ();
}

Error Unexpected(const std::string& text) {
  return Error{ErrorCode::kInvalidArgument,
               Format("symmetry \"%s\", expected none, cyclic:ORDER:AXIS, "
                      "dihedral:ORDER:AXIS:HALF_TURN_AXIS, continuous:AXIS or "
                      "continuous-flip:AXIS with an AXIS like z or 0,0.6,0.8",
                      text.c_str())};
}

std::vector<std::string_view> Split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (true) {
    const size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

template <class Number>
std::optional<Number> ParseNumber(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<Eigen::Vector3d> ParseAxis(std::string_view text) {
  if (text == "x") return Eigen::Vector3d::UnitX();
  if (text == "y") return Eigen::Vector3d::UnitY();
  if (text == "z") return Eigen::Vector3d::UnitZ();
  const std::vector<std::string_view> parts = Split(text, ',');
  if (parts.size() != 3) return std::nullopt;
  Eigen::Vector3d axis;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const std::optional<double> value = ParseNumber<double>(parts[static_cast<size_t>(i)]);
    if (!value) return std::nullopt;
    axis[i] = *value;
  }
  return axis;
}

bool IsAxis(const Eigen::Vector3d& axis) {
  return axis.allFinite() && axis.norm() > 1e-6 && axis.norm() < 1e6;
}

std::string AxisText(const Eigen::Vector3d& axis) {
  // What is left of rounding is no part of a direction. Adding 0 turns -0 into 0.
  constexpr double kRounding = 1e-6;
  const Eigen::Vector3d told = (axis.array().abs() < kRounding).select(0.0, axis.array() + 0.0);
  return Format("(%.4g, %.4g, %.4g)", told.x(), told.y(), told.z());
}

}  // namespace

SymmetryDescription DescribeSymmetry(const SymmetryGroup& group) {
  SymmetryDescription description;
  description.axis = group.axis;
  if (group.kind == SymmetryGroup::Kind::kContinuous) {
    description.kind = Kind::kContinuous;
    description.flips = group.flips;
    return description;
  }
  const size_t size = group.elements.size();
  if (size <= 1) return description;
  if (size > 2 * kLargestOrder) {
    description.kind = Kind::kFinite;
    return description;
  }
  description.order = static_cast<int>(size);
  description.kind = Kind::kCyclic;
  description.axis = MainAxis(group);
  if (size <= kLargestOrder) {
    if (SameElements(SymmetryGroup::Cyclic(description.order, description.axis), group)) {
      return description;
    }
  }
  if (size % 2 == 0) {
    description.kind = Kind::kDihedral;
    description.order = static_cast<int>(size / 2);
    description.half_turn_axis = HalfTurnAxis(group, description.axis);
    if (std::abs(description.half_turn_axis.dot(description.axis)) < kSameAxis &&
        SameElements(SymmetryGroup::Dihedral(
                         description.order, description.axis, description.half_turn_axis),
                     group)) {
      return description;
    }
  }
  description.kind = Kind::kFinite;
  return description;
}

Result<SymmetryGroup> MakeSymmetry(const SymmetryDescription& description) {
  const auto [kind, order, axis, half_turn_axis, flips] = description;
  if (kind == Kind::kNone) return SymmetryGroup::None();
  if (!IsAxis(axis)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("symmetry axis (%g, %g, %g), expected a direction of length 1",
                        axis.x(),
                        axis.y(),
                        axis.z())};
  }
  if (kind == Kind::kContinuous) return SymmetryGroup::Continuous(axis, flips);
  if (order < 1 || order > kLargestOrder) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("symmetry order %d, expected 1 to %d", order, kLargestOrder)};
  }
  if (kind == Kind::kCyclic) return SymmetryGroup::Cyclic(order, axis);
  if (!IsAxis(half_turn_axis) ||
      std::abs(half_turn_axis.normalized().dot(axis.normalized())) > 0.1) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("half turn axis (%g, %g, %g), expected a direction perpendicular to the "
                        "symmetry axis (%g, %g, %g)",
                        half_turn_axis.x(),
                        half_turn_axis.y(),
                        half_turn_axis.z(),
                        axis.x(),
                        axis.y(),
                        axis.z())};
  }
  return SymmetryGroup::Dihedral(order, axis, half_turn_axis);
}

Result<SymmetryGroup> ParseSymmetry(const std::string& text) {
  const std::vector<std::string_view> parts = Split(text, ':');
  SymmetryDescription description;
  size_t axis_at = 1;
  if (parts[0] == "none" && parts.size() == 1) return SymmetryGroup::None();
  if ((parts[0] == "cyclic" && parts.size() == 3) ||
      (parts[0] == "dihedral" && parts.size() == 4)) {
    description.kind = parts[0] == "cyclic" ? Kind::kCyclic : Kind::kDihedral;
    const std::optional<int> order = ParseNumber<int>(parts[1]);
    if (!order) return Unexpected(text);
    description.order = *order;
    axis_at = 2;
  } else if ((parts[0] == "continuous" || parts[0] == "continuous-flip") && parts.size() == 2) {
    description.kind = Kind::kContinuous;
    description.flips = parts[0] == "continuous-flip";
  } else {
    return Unexpected(text);
  }
  const std::optional<Eigen::Vector3d> axis = ParseAxis(parts[axis_at]);
  if (!axis) return Unexpected(text);
  description.axis = *axis;
  if (description.kind == Kind::kDihedral) {
    const std::optional<Eigen::Vector3d> half_turn_axis = ParseAxis(parts[3]);
    if (!half_turn_axis) return Unexpected(text);
    description.half_turn_axis = *half_turn_axis;
  }
  return MakeSymmetry(description);
}

std::string SymmetryText(const SymmetryGroup& group) {
  const SymmetryDescription description = DescribeSymmetry(group);
  const std::string axis = AxisText(description.axis);
  switch (description.kind) {
    case Kind::kNone:
      return "none";
    case Kind::kCyclic:
      return Format("%d-fold about %s", description.order, axis.c_str());
    case Kind::kDihedral:
      return Format("%d-fold about %s with half turns about %s",
                    description.order,
                    axis.c_str(),
                    AxisText(description.half_turn_axis).c_str());
    case Kind::kContinuous:
      return Format("continuous about %s%s", axis.c_str(), description.flips ? " with flips" : "");
    case Kind::kFinite:
      return Format("finite, %zu rotations", group.elements.size());
  }
  return "none";
}

}  // namespace vantage
