#include "fusion/symmetry/measured_symmetry.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "common/format.h"
#include "fusion/so3_grid.h"
#include "fusion/symmetry/closed_group.h"
#include "fusion/symmetry/turned_surface.h"

namespace vantage {
namespace {

using Motion = TurnedSurface::Motion;

constexpr double kSame = 5.0 * kDegree;    // Rotations closer than that are one.
constexpr double kClear = 20.0 * kDegree;  // Rotations from here on have a certain axis.
constexpr double kGolden = std::numbers::pi * 0.76393202250021030;  // 3 - sqrt(5): fills a circle.

struct Candidate {
  Motion motion;
  double error;  // Diameters.
};

Eigen::Quaterniond RotationOf(const Motion& motion) {
  return Eigen::Quaterniond(motion.linear).normalized();
}

Eigen::Matrix3d Turn(const Eigen::Vector3d& axis, double angle) {
  return ExpSo3(std::remainder(angle, 2.0 * std::numbers::pi) * axis).toRotationMatrix();
}

// The point, nearest to the centroid, about which motions turn: the least squares solution of
// (I - R) p = t over all of them.
Eigen::Vector3d CommonCenter(std::span<const Motion> motions) {
  Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
  for (const Motion& motion : motions) {
    const Eigen::Matrix3d a = Eigen::Matrix3d::Identity() - motion.linear;
    normal_matrix += a.transpose() * a;
    right_side += a.transpose() * motion.shift;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(normal_matrix);
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double value = solver.eigenvalues()[i];
    // Along a common axis every point is as good.
    if (value < 1e-3 * solver.eigenvalues()[2] || value <= 0.0) continue;
    const Eigen::Vector3d direction = solver.eigenvectors().col(i);
    center += direction * (direction.dot(right_side) / value);
  }
  return center;
}

// The principal axis of rotation axes (paper 6.3), each counted by how certain it is.
Eigen::Vector3d PrincipalAxis(std::span<const Motion> motions) {
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (const Motion& motion : motions) {
    const Eigen::Vector3d part = RotationOf(motion).vec();
    moments += part * part.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(moments).eigenvectors().col(2);
}

bool IsNear(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double angle) {
  return a.cross(b).norm() < std::sin(angle);
}

// A finite group about a common center.
struct FiniteGroup {
  std::vector<Eigen::Quaterniond> elements = {Eigen::Quaterniond::Identity()};
  std::vector<double> errors = {0.0};  // Diameters.
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
};

// All rotations about an axis.
struct Revolution {
  Eigen::Vector3d axis;
  Eigen::Vector3d center;
  double error;  // Diameters, of the worst.
};

class SymmetrySearch {
 public:
  SymmetrySearch(const TriangleMesh& mesh, const MeasuredSymmetryParameters& parameters)
      : parameters_(parameters),
        object_(mesh, parameters.num_samples, parameters.seed),
        tolerance_(parameters.tolerance) {}

  FoundSymmetry Run() {
    FindCandidates();
    const std::vector<Revolution> revolutions = FindRevolutions();
    FoundSymmetry found;
    if (revolutions.size() > 1) {
      found.is_sphere = true;
      found.group = SymmetryGroup::Continuous(Eigen::Vector3d::UnitZ(), true);
      found.residual = std::max(revolutions[0].error, revolutions[1].error);
      found.confidence = Weight(found.residual);
      SetCenter(CommonSphereCenter(revolutions), &found);
      return found;
    }
    found = revolutions.empty() ? Finite() : Continuous(revolutions.front());
    AddMirrors(&found);
    return found;
  }

 private:
  // Root of the mean squared distance and of the centroid's way, diameters.
  [[nodiscard]] double Error(const Motion& motion) const {
    const double mse = object_.Mse(motion) + motion.shift.squaredNorm();
    return std::sqrt(mse) / object_.diameter();
  }

  // Paper eq. 14, 0.5 at the tolerance.
  [[nodiscard]] double Weight(double error) const {
    const double ratio = error / tolerance_;
    return std::exp2(-std::pow(ratio, 4));
  }

  [[nodiscard]] Candidate Refined(const Eigen::Matrix3d& linear) const {
    constexpr int kUsed = 200;
    const Motion motion = object_.Register({linear, Eigen::Vector3d::Zero()}, kUsed);
    return {motion, Error(motion)};
  }

  [[nodiscard]] double CoarseError(const Motion& motion) const {
    return std::sqrt(object_.CoarseMse(motion)) / object_.diameter();
  }

  // False where a few samples already tell that no symmetry lies near.
  [[nodiscard]] bool MayBeNearSymmetry(const Eigen::Matrix3d& linear) const {
    constexpr int kFew = 60;
    const double loose = 2.5 * parameters_.tolerance;
    return CoarseError(object_.RegisterCoarsely({linear, Eigen::Vector3d::Zero()}, kFew)) <= loose;
  }

  // The representative orientations of least error, none near another.
  [[nodiscard]] std::vector<Eigen::Quaterniond> CoarseMinima() const {
    constexpr double kHopeless = 0.1;  // Diameters; the grid alone makes half of that.
    constexpr size_t kMost = 150;
    struct Tried {
      Eigen::Quaterniond turn;
      double error;
    };
    const So3Grid grid(parameters_.k);
    std::vector<Tried> tried;
    for (const So3Grid::Cell cell : grid.ValidCells()) {
      const Eigen::Quaterniond turn = grid.Representative(cell);
      const double error = CoarseError({turn.toRotationMatrix(), Eigen::Vector3d::Zero()});
      if (error < kHopeless) tried.push_back({turn, error});
    }
    std::stable_sort(tried.begin(), tried.end(), [](const Tried& a, const Tried& b) {
      return a.error < b.error;
    });
    const double apart = 88.0 / parameters_.k * kDegree;  // About the distance of neighbors.
    std::vector<Eigen::Quaterniond> minima;
    for (const Tried& one : tried) {
      if (minima.size() == kMost) break;
      if (!FindElement(minima, one.turn, apart)) minima.push_back(one.turn);
    }
    return minima;
  }

  // Registered rotations, best first, none near another; and the tolerance that they tell.
  void FindCandidates() {
    for (const Eigen::Quaterniond& minimum : CoarseMinima()) {
      const Eigen::Matrix3d linear = minimum.toRotationMatrix();
      if (!MayBeNearSymmetry(linear)) continue;
      const Candidate candidate = Refined(linear);
      const Eigen::Quaterniond turn = RotationOf(candidate.motion);
      if (GeodesicAngle(turn, Eigen::Quaterniond::Identity()) < kClear) continue;
      const bool is_known =
          std::any_of(candidates_.begin(), candidates_.end(), [&](const Candidate& other) {
            return GeodesicAngle(turn, RotationOf(other.motion)) < 0.2 * kSame;
          });
      if (!is_known) candidates_.push_back(candidate);
    }
    std::stable_sort(candidates_.begin(),
                     candidates_.end(),
                     [](const Candidate& a, const Candidate& b) { return a.error < b.error; });
    if (candidates_.empty()) return;
    tolerance_ = std::clamp(parameters_.unevenness_factor * candidates_.front().error,
                            parameters_.least_tolerance,
                            parameters_.tolerance);
  }

  // Axes about which every rotation is a symmetry, at most two, far from each other.
  [[nodiscard]] std::vector<Revolution> FindRevolutions() const {
    std::vector<Eigen::Vector3d> tried;
    std::vector<Revolution> found;
    for (const Candidate& candidate : candidates_) {
      if (candidate.error > tolerance_) break;
      const Eigen::Vector3d axis = LogSo3(RotationOf(candidate.motion)).normalized();
      if (!found.empty() && IsNear(axis, found.front().axis, 20.0 * kDegree)) continue;
      const bool is_known = std::any_of(tried.begin(), tried.end(), [&](const auto& other) {
        return IsNear(axis, other, 2.0 * kDegree);
      });
      if (is_known) continue;
      tried.push_back(axis);
      const std::optional<Revolution> revolution = RevolutionAbout(axis);
      if (revolution) found.push_back(*revolution);
      if (found.size() == 2) break;
    }
    return found;
  }

  [[nodiscard]] std::optional<Revolution> RevolutionAbout(const Eigen::Vector3d& near) const {
    constexpr int kRegistered = 6;
    std::vector<Motion> motions;
    for (int i = 1; i <= kRegistered; ++i) {
      const Motion motion = Refined(Turn(near, i * kGolden)).motion;
      const Eigen::Vector3d turn = LogSo3(RotationOf(motion));
      // Some slide to no turn at all.
      if (turn.norm() > kClear && IsNear(turn.normalized(), near, 10.0 * kDegree)) {
        motions.push_back(motion);
      }
    }
    if (motions.size() < 2) return std::nullopt;
    Revolution result{PrincipalAxis(motions), CommonCenter(motions), 0.0};
    Eigen::Index largest = 0;
    result.axis.cwiseAbs().maxCoeff(&largest);
    if (result.axis[largest] < 0.0) result.axis = -result.axis;
    result.center -= result.axis * result.axis.dot(result.center);
    constexpr int kAngles = 32;  // Multiples of the golden angle hit every gap between teeth.
    for (int i = 1; i <= kAngles; ++i) {
      const Motion motion = Motion::About(Turn(result.axis, i * kGolden), result.center);
      result.error = std::max(result.error, Error(motion));
      if (result.error > tolerance_) return std::nullopt;
    }
    return result;
  }

  [[nodiscard]] static Eigen::Vector3d CommonSphereCenter(const std::vector<Revolution>& axes) {
    std::vector<Motion> half_turns;
    for (const Revolution& one : axes) {
      half_turns.push_back(Motion::About(Turn(one.axis, std::numbers::pi), one.center));
    }
    return CommonCenter(half_turns);
  }

  void SetCenter(const Eigen::Vector3d& center, FoundSymmetry* found) const {
    found->center = object_.centroid() + center;
    found->center_offset = center.norm();
  }

  [[nodiscard]] FoundSymmetry Continuous(const Revolution& revolution) const {
    const Eigen::Vector3d across = revolution.axis.unitOrthogonal();
    std::vector<Motion> motions = {
        Motion::About(Turn(revolution.axis, std::numbers::pi), revolution.center)};
    std::vector<Eigen::Matrix3d> flips;
    constexpr int kFlips = 4;
    for (int i = 0; i < kFlips; ++i) {
      const Eigen::Vector3d about = Turn(revolution.axis, i * kGolden) * across;
      flips.push_back(Turn(about, std::numbers::pi));
      motions.push_back(Refined(flips.back()).motion);
    }
    // Only the place along the axis is new.
    const Eigen::Vector3d along = revolution.axis * revolution.axis.dot(CommonCenter(motions));
    double flip_error = 0.0;
    for (const Eigen::Matrix3d& flip : flips) {
      flip_error = std::max(flip_error, Error(Motion::About(flip, revolution.center + along)));
    }
    const bool is_flipping = flip_error <= tolerance_;
    FoundSymmetry found;
    found.group = SymmetryGroup::Continuous(revolution.axis, is_flipping);
    found.axes = AxesOf(found.group, {Weight(revolution.error), Weight(flip_error)});
    found.residual = is_flipping ? std::max(revolution.error, flip_error) : revolution.error;
    const double of_flips = is_flipping ? Weight(flip_error) : 1.0 - Weight(flip_error);
    found.confidence = std::min(Weight(revolution.error), of_flips);
    SetCenter(is_flipping ? Eigen::Vector3d(revolution.center + along) : revolution.center, &found);
    return found;
  }

  // Makes rotations a group about one center; none when it is no symmetry as a whole.
  [[nodiscard]] std::optional<FiniteGroup> Judged(std::vector<Eigen::Quaterniond> elements) const {
    MakeExact(&elements, kSame);
    std::vector<Motion> motions;
    for (const Eigen::Quaterniond& element : elements) {
      if (&element == &elements.front()) continue;
      motions.push_back(Refined(element.toRotationMatrix()).motion);
    }
    FiniteGroup group{std::move(elements), {}, CommonCenter(motions)};
    for (const Eigen::Quaterniond& element : group.elements) {
      const double error = Error(Motion::About(element.toRotationMatrix(), group.center));
      if (error > tolerance_) return std::nullopt;
      group.errors.push_back(error);
    }
    return group;
  }

  [[nodiscard]] FoundSymmetry Finite() const {
    const auto find = [this](const Eigen::Quaterniond& near) -> std::optional<Eigen::Quaterniond> {
      const Candidate candidate = Refined(near.toRotationMatrix());
      if (candidate.error > tolerance_) return std::nullopt;
      return RotationOf(candidate.motion);
    };
    FiniteGroup group;
    double rejected = 0.0;  // Weight of the best rotation that is not in the group.
    for (const Candidate& candidate : candidates_) {
      const Eigen::Quaterniond turn = RotationOf(candidate.motion);
      if (FindElement(group.elements, turn, kSame)) continue;
      std::optional<FiniteGroup> larger;
      if (candidate.error <= tolerance_) {
        const auto joined = JoinGroup(group.elements, turn, kSame, find);
        if (joined) larger = Judged(*joined);
      }
      if (larger) {
        group = *larger;
      } else {
        // One that fits alone, but not about a center with its products, is no symmetry either.
        rejected = std::max(rejected, std::min(0.5, Weight(candidate.error)));
      }
    }
    FoundSymmetry found;
    found.group.elements = group.elements;
    std::vector<double> weights;
    for (const double error : group.errors) weights.push_back(Weight(error));
    found.axes = AxesOf(found.group, weights);
    if (!found.axes.empty()) found.group.axis = found.axes.front().direction;
    found.residual = *std::max_element(group.errors.begin(), group.errors.end());
    found.confidence = std::min(Weight(found.residual), 1.0 - rejected);
    SetCenter(group.center, &found);
    return found;
  }

  // Normals of the planes that reflections are tried about.
  [[nodiscard]] std::vector<Eigen::Vector3d> MirrorCandidates(const FoundSymmetry& found) const {
    if (found.group.kind == SymmetryGroup::Kind::kContinuous) {
      return {found.group.axis, found.group.axis.unitOrthogonal()};
    }
    struct Tried {
      Eigen::Vector3d normal;
      double error;
    };
    constexpr int kDirections = 600;  // Of half the sphere: some 6 degrees apart.
    constexpr size_t kMost = 12;
    std::vector<Tried> tried;
    for (int i = 0; i < kDirections; ++i) {
      const double z = (i + 0.5) / kDirections;
      const double r = std::sqrt(1.0 - z * z);
      const Eigen::Vector3d n(r * std::cos(i * kGolden), r * std::sin(i * kGolden), z);
      tried.push_back({n, CoarseError({Reflection(n), Eigen::Vector3d::Zero()})});
    }
    std::stable_sort(tried.begin(), tried.end(), [](const Tried& a, const Tried& b) {
      return a.error < b.error;
    });
    std::vector<Eigen::Vector3d> normals;
    for (const Tried& one : tried) {
      if (normals.size() == kMost) break;
      const bool is_near = std::any_of(normals.begin(), normals.end(), [&](const auto& other) {
        return IsNear(other, one.normal, 10.0 * kDegree);
      });
      if (!is_near) normals.push_back(one.normal);
    }
    return normals;
  }

  static Eigen::Matrix3d Reflection(const Eigen::Vector3d& normal) {
    return Eigen::Matrix3d::Identity() - 2.0 * normal * normal.transpose();
  }

  void AddMirrors(FoundSymmetry* found) const {
    for (const Eigen::Vector3d& near : MirrorCandidates(*found)) {
      const Motion motion = Refined(Reflection(near)).motion;
      const Eigen::Matrix3d even = 0.5 * (motion.linear + motion.linear.transpose());
      const Eigen::Vector3d normal =
          Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(even).eigenvectors().col(0);
      const double error =
          Error({Reflection(normal), Eigen::Vector3d(normal * normal.dot(motion.shift))});
      if (error > tolerance_) continue;
      const bool is_known = std::any_of(
          found->mirrors.begin(), found->mirrors.end(), [&](const FoundSymmetry::Mirror& other) {
            return IsNear(other.normal, normal, kSame);
          });
      if (!is_known) found->mirrors.push_back({normal, error});
    }
  }

  MeasuredSymmetryParameters parameters_;
  TurnedSurface object_;
  double tolerance_;  // Diameters.
  std::vector<Candidate> candidates_;
};

Result<void> CheckMesh(const TriangleMesh& mesh) {
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    if (!vertex.allFinite() || vertex.norm() > 1e6F) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("mesh has a vertex at (%g, %g, %g) m, expected finite and within 1e6 m",
                          static_cast<double>(vertex.x()),
                          static_cast<double>(vertex.y()),
                          static_cast<double>(vertex.z()))};
    }
  }
  for (const std::array<uint32_t, 3>& triangle : mesh.triangles) {
    for (const uint32_t vertex : triangle) {
      if (vertex < mesh.vertices.size()) continue;
      return Error{ErrorCode::kInvalidArgument,
                   Format("mesh has a triangle with vertex %u, expected below %zu",
                          vertex,
                          mesh.vertices.size())};
    }
  }
  if (!(mesh.Area() > 0.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("mesh of %zu triangles has no area, expected some", mesh.triangles.size())};
  }
  return {};
}

}  // namespace

Result<void> MeasuredSymmetryParameters::Validate() const {
  if (k < 2 || k > 16) {
    return Error{ErrorCode::kInvalidArgument, Format("k = %d, expected 2 to 16", k)};
  }
  if (num_samples < 50 || num_samples > 100000) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("num_samples = %d, expected 50 to 100000", num_samples)};
  }
  if (!(tolerance > 0.0 && tolerance <= 0.1)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("tolerance = %g diameters, expected above 0 and at most 0.1", tolerance)};
  }
  if (!(least_tolerance > 0.0 && least_tolerance <= tolerance)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("least_tolerance = %g diameters, expected above 0 and at most the "
                        "tolerance, %g",
                        least_tolerance,
                        tolerance)};
  }
  if (!(unevenness_factor >= 1.0 && unevenness_factor <= 1e6)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("unevenness_factor = %g, expected 1 to 1e6", unevenness_factor)};
  }
  return {};
}

Result<FoundSymmetry> MeasureSymmetry(const TriangleMesh& mesh,
                                      const MeasuredSymmetryParameters& parameters) {
  if (const Result<void> valid = parameters.Validate(); !valid) return valid.error();
  if (const Result<void> valid = CheckMesh(mesh); !valid) return valid.error();
  return SymmetrySearch(mesh, parameters).Run();
}

}  // namespace vantage
