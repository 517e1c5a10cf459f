#include "fusion/symmetry/measured_symmetry.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "common/format.h"
#include "fusion/symmetry/nearest_surface.h"
#include "fusion/quaternion_mean.h"
#include "fusion/so3_grid.h"

namespace vantage {
namespace {

constexpr double kSame = 5.0 * kDegree;  // Rotations closer than that are one.
constexpr size_t kLargestGroup = 120;    // Twice the icosahedron's, and Cyclic(120): 3 degrees.

// Distances to a surface, tabulated on a lattice over a cube about 0 and interpolated: coarse, but
// a thousand times as fast as a search.
class DistanceField {
 public:
  // @param reach m, half the cube's edge.
  DistanceField(const NearestSurface& surface, double reach) : reach_(reach) {
    values_.reserve(kSize * kSize * kSize);
    for (size_t x = 0; x < kSize; ++x) {
      for (size_t y = 0; y < kSize; ++y) {
        for (size_t z = 0; z < kSize; ++z) {
          values_.push_back(surface.Nearest({At(x), At(y), At(z)}).distance);
        }
      }
    }
  }

  [[nodiscard]] double Distance(const Eigen::Vector3d& point) const {
    std::array<size_t, 3> low{};
    std::array<double, 3> share{};
    for (size_t i = 0; i < 3; ++i) {
      const double place = (point[static_cast<Eigen::Index>(i)] / reach_ + 1.0) * kHalf;
      const double clamped = std::clamp(place, 0.0, 2.0 * kHalf - 1e-6);
      low[i] = static_cast<size_t>(clamped);
      share[i] = clamped - static_cast<double>(low[i]);
    }
    double sum = 0.0;
    for (size_t corner = 0; corner < 8; ++corner) {
      double weight = 1.0;
      size_t index = 0;
      for (size_t i = 0; i < 3; ++i) {
        const size_t step = (corner >> i) & 1U;
        weight *= step == 1 ? share[i] : 1.0 - share[i];
        index = index * kSize + low[i] + step;
      }
      sum += weight * values_[index];
    }
    return sum;
  }

 private:
  static constexpr size_t kSize = 41;
  static constexpr double kHalf = 0.5 * (kSize - 1);

  [[nodiscard]] double At(size_t i) const {
    return reach_ * (static_cast<double>(i) / kHalf - 1.0);
  }

  double reach_;
  std::vector<double> values_;
};

// A mesh moved so that its surface's centroid is at 0, and samples of it.
class TurnedSurface {
 public:
  TurnedSurface(const TriangleMesh& centered, const MeasuredSymmetryParameters& parameters)
      : surface_(centered), bound_(parameters.tolerance * centered.Diameter()) {
    Rng rng(parameters.seed);
    const auto count = static_cast<size_t>(parameters.num_samples);
    for (const SurfacePoint& point : SampleSurface(centered, count, rng)) {
      samples_.push_back(point.position.cast<double>());
    }
  }

  // Mean squared distance of every n-th sample, turned, to the surface, m^2.
  [[nodiscard]] double Mse(const Eigen::Quaterniond& turn, size_t stride = 1) const {
    const Eigen::Matrix3d R = turn.toRotationMatrix();
    double sum = 0.0;
    for (size_t i = 0; i < samples_.size(); i += stride) {
      const double distance = surface_.Nearest(R * samples_[i]).distance;
      sum += distance * distance;
    }
    return sum * static_cast<double>(stride) / static_cast<double>(samples_.size());
  }

  [[nodiscard]] bool IsSymmetry(const Eigen::Quaterniond& turn) const { return Allows(Mse(turn)); }
  [[nodiscard]] bool Allows(double mse) const { return mse <= bound_ * bound_; }

  // False where a few samples already tell that no symmetry lies near `turn`.
  [[nodiscard]] bool MayBeNearSymmetry(const Eigen::Quaterniond& turn) const {
    constexpr size_t kFew = 50;
    const size_t stride = samples_.size() / kFew;
    const double loose = 3.0 * bound_;
    return Mse(Refine(turn, kFew), stride) <= loose * loose;
  }

  // The minimum of the error near `turn`: Gauss-Newton on the distances to the tangent planes of
  // the nearest points (Chen and Medioni 1992), rotation only.
  // @param count of the samples that take part.
  [[nodiscard]] Eigen::Quaterniond Refine(Eigen::Quaterniond turn, size_t count = 200) const {
    constexpr int kSteps = 12;
    const size_t stride = std::max<size_t>(1, samples_.size() / count);
    for (int step = 0; step < kSteps; ++step) {
      const Eigen::Matrix3d R = turn.toRotationMatrix();
      Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
      Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
      for (size_t i = 0; i < samples_.size(); i += stride) {
        const Eigen::Vector3d point = R * samples_[i];
        const NearestSurface::Hit hit = surface_.Nearest(point);
        const Eigen::Vector3d jacobian = point.cross(hit.normal);
        normal_matrix += jacobian * jacobian.transpose();
        right_side -= jacobian * hit.normal.dot(point - hit.point);
      }
      // Damped: along a continuous symmetry nothing changes.
      normal_matrix.diagonal().array() += 1e-6 * normal_matrix.trace() + 1e-30;
      Eigen::Vector3d change = normal_matrix.ldlt().solve(right_side);
      constexpr double kLongest = 10.0 * kDegree;
      if (change.norm() > kLongest) change *= kLongest / change.norm();
      turn = (ExpSo3(change) * turn).normalized();
      if (change.norm() < 1e-6) break;
    }
    return turn;
  }

  [[nodiscard]] const NearestSurface& surface() const { return surface_; }
  [[nodiscard]] const std::vector<Eigen::Vector3d>& samples() const { return samples_; }

 private:
  NearestSurface surface_;
  double bound_;  // m, of the root mean square distance.
  std::vector<Eigen::Vector3d> samples_;
};

struct TriedRotation {
  Eigen::Quaterniond turn;
  double mse;
};

void SortByError(std::vector<TriedRotation>* tried) {
  std::stable_sort(
      tried->begin(), tried->end(), [](const auto& a, const auto& b) { return a.mse < b.mse; });
}

// The representative orientations of least error, none near another.
std::vector<TriedRotation> CoarseMinima(const TurnedSurface& object, int k) {
  double reach = 0.0;
  for (const Eigen::Vector3d& sample : object.samples()) reach = std::max(reach, sample.norm());
  const DistanceField field(object.surface(), reach);
  const So3Grid grid(k);
  std::vector<TriedRotation> tried;
  for (const So3Grid::Cell cell : grid.ValidCells()) {
    const Eigen::Quaterniond turn = grid.Representative(cell);
    const Eigen::Matrix3d R = turn.toRotationMatrix();
    double sum = 0.0;
    for (const Eigen::Vector3d& sample : object.samples()) {
      const double distance = field.Distance(R * sample);
      sum += distance * distance;
    }
    tried.push_back({turn, sum / static_cast<double>(object.samples().size())});
  }
  SortByError(&tried);
  constexpr size_t kMost = 200;
  const double apart = 88.0 / k * kDegree;  // About the distance of the grid's neighbors.
  std::vector<TriedRotation> minima;
  for (const TriedRotation& one : tried) {
    if (minima.size() == kMost) break;
    const bool is_near = std::any_of(minima.begin(), minima.end(), [&](const TriedRotation& other) {
      return GeodesicAngle(one.turn, other.turn) < apart;
    });
    if (!is_near) minima.push_back(one);
  }
  return minima;
}

std::optional<size_t> Find(const std::vector<Eigen::Quaterniond>& group,
                           const Eigen::Quaterniond& turn) {
  for (size_t i = 0; i < group.size(); ++i) {
    if (GeodesicAngle(group[i], turn) < kSame) return i;
  }
  return std::nullopt;
}

// The smallest group that holds both; none when a product is no symmetry.
std::optional<std::vector<Eigen::Quaterniond>> Join(const TurnedSurface& object,
                                                    std::vector<Eigen::Quaterniond> group,
                                                    const Eigen::Quaterniond& turn) {
  group.push_back(turn);
  for (size_t i = 0; i < group.size(); ++i) {
    for (size_t j = 0; j <= i; ++j) {
      for (const Eigen::Quaterniond& product : {group[i] * group[j], group[j] * group[i]}) {
        if (Find(group, product)) continue;
        const Eigen::Quaterniond refined = object.Refine(product);
        if (group.size() == kLargestGroup || Find(group, refined) || !object.IsSymmetry(refined)) {
          return std::nullopt;
        }
        group.push_back(refined);
      }
    }
  }
  return group;
}

// Makes the products of a measured group its elements to rounding: each element becomes the mean
// of all quotients that should equal it.
void MakeExact(std::vector<Eigen::Quaterniond>* group) {
  for (int round = 0; round < 3; ++round) {
    std::vector<Eigen::Quaterniond> better;
    for (const Eigen::Quaterniond& element : *group) {
      std::vector<WeightedOrientation> quotients;
      for (const Eigen::Quaterniond& other : *group) {
        const std::optional<size_t> product = Find(*group, element * other);
        if (product) quotients.push_back({(*group)[*product] * other.conjugate(), 1.0});
      }
      better.push_back(WeightedMean(quotients));
    }
    *group = better;
  }
  group->front() = Eigen::Quaterniond::Identity();
}

bool IsContinuousAxis(const TurnedSurface& object, const Eigen::Vector3d& axis) {
  constexpr int kAngles = 32;
  for (int i = 1; i <= kAngles; ++i) {
    // Multiples of the golden angle hit every gap between the teeth of a wheel.
    const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    if (!object.IsSymmetry(ExpSo3(std::remainder(angle, 2.0 * std::numbers::pi) * axis))) {
      return false;
    }
  }
  return true;
}

// Axes about which every rotation is a symmetry, at most two, far from each other.
std::vector<Eigen::Vector3d> ContinuousAxes(const TurnedSurface& object,
                                            const std::vector<TriedRotation>& symmetries) {
  const auto is_near = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b, double angle) {
    return a.cross(b).norm() < std::sin(angle);
  };
  std::vector<Eigen::Vector3d> tried;
  std::vector<Eigen::Vector3d> found;
  for (const TriedRotation& symmetry : symmetries) {
    const Eigen::Vector3d turn = LogSo3(symmetry.turn);
    if (turn.norm() < 30.0 * kDegree) continue;  // Its axis is uncertain.
    const Eigen::Vector3d axis = turn.normalized();
    if (!found.empty() && is_near(axis, found.front(), 20.0 * kDegree)) continue;
    const bool is_known = std::any_of(tried.begin(), tried.end(), [&](const auto& other) {
      return is_near(axis, other, 2.0 * kDegree);
    });
    if (is_known) continue;
    tried.push_back(axis);
    if (IsContinuousAxis(object, axis)) found.push_back(axis);
    if (found.size() == 2) break;
  }
  return found;
}

Result<SymmetryGroup> ContinuousGroup(const TurnedSurface& object,
                                      const std::vector<Eigen::Vector3d>& axes) {
  if (axes.size() > 1) {
    return Error{ErrorCode::kInvalidArgument,
                 "the mesh is symmetric about every axis, expected one axis or finitely many "
                 "rotations"};
  }
  Eigen::Index largest = 0;
  axes.front().cwiseAbs().maxCoeff(&largest);
  const Eigen::Vector3d axis = axes.front()[largest] < 0.0 ? -axes.front() : axes.front();
  const Eigen::Vector3d across = axis.unitOrthogonal();
  return SymmetryGroup::Continuous(axis, object.IsSymmetry(ExpSo3(std::numbers::pi * across)));
}

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
  return {};
}

Result<SymmetryGroup> MeasureSymmetry(const TriangleMesh& mesh,
                                      const MeasuredSymmetryParameters& parameters) {
  if (const Result<void> valid = parameters.Validate(); !valid) return valid.error();
  if (const Result<void> valid = CheckMesh(mesh); !valid) return valid.error();
  TriangleMesh centered = mesh;
  const Eigen::Vector3f center = mesh.SurfaceCentroid().cast<float>();
  for (Eigen::Vector3f& vertex : centered.vertices) vertex -= center;
  const TurnedSurface object(centered, parameters);

  std::vector<TriedRotation> symmetries;
  for (const TriedRotation& minimum : CoarseMinima(object, parameters.k)) {
    if (!object.MayBeNearSymmetry(minimum.turn)) continue;
    const Eigen::Quaterniond turn = object.Refine(minimum.turn);
    const double mse = object.Mse(turn);
    if (object.Allows(mse)) symmetries.push_back({turn, mse});
  }
  SortByError(&symmetries);
  const std::vector<Eigen::Vector3d> axes = ContinuousAxes(object, symmetries);
  if (!axes.empty()) return ContinuousGroup(object, axes);

  SymmetryGroup group;
  for (const TriedRotation& symmetry : symmetries) {
    if (Find(group.elements, symmetry.turn)) continue;
    const auto joined = Join(object, group.elements, symmetry.turn);
    if (joined) group.elements = *joined;
  }
  MakeExact(&group.elements);
  return group;
}

}  // namespace vantage
