#include "fusion/symmetry/table_symmetry.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "common/format.h"
#include "fusion/bingham/bingham_distribution.h"
#include "fusion/quaternion_mean.h"
#include "fusion/symmetry/closed_group.h"
#include "fusion/symmetry/symmetry_weights.h"

namespace vantage {
namespace {

constexpr double kSame = 10.0 * kDegree;  // Rotations closer than that are one.

// Neighboring heavy cells.
struct Cluster {
  enum class Shape { kPoint, kCircle, kBall };
  Shape shape = Shape::kPoint;
  double weight = 0.0;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // Point: the mode.
  Eigen::Vector4d z = Eigen::Vector4d::Zero();                   // Of the Bingham distribution.
  Eigen::Matrix4d directions = Eigen::Matrix4d::Identity();

  // Angle to the nearest rotation of a point or circle, rad.
  [[nodiscard]] double AngleTo(const Eigen::Quaterniond& q) const {
    if (shape == Shape::kPoint) return GeodesicAngle(rotation, q);
    if (shape == Shape::kBall) return 0.0;
    const double inside = (directions.rightCols<2>().transpose() * q.coeffs()).norm();
    return 2.0 * std::acos(std::min(1.0, inside));
  }
};

// A Bingham distribution of concentration z has a spread of sqrt(-2 / z) rad about an axis.
Cluster ShapeOf(const std::vector<SymmetryWeight>& members, const So3Grid& grid) {
  Cluster cluster;
  Eigen::Matrix4d scatter = Eigen::Matrix4d::Zero();
  for (const auto& [cell, weight] : members) {
    const Eigen::Vector4d q = grid.Representative(cell).coeffs();
    scatter += weight * q * q.transpose();
    cluster.weight += weight;
  }
  const BinghamDistribution fit = BinghamDistribution::Fit(scatter / cluster.weight);
  cluster.z = fit.z();
  cluster.directions = fit.directions();
  cluster.rotation = fit.Mode();
  constexpr double kFlat = -3.0;    // Hardly denser anywhere.
  constexpr double kSteep = -20.0;  // Within 20 degrees.
  if (fit.z()[0] > kFlat) {
    cluster.shape = Cluster::Shape::kBall;
  } else if (fit.z()[2] > kFlat && fit.z()[1] < kSteep) {
    cluster.shape = Cluster::Shape::kCircle;
  }
  return cluster;
}

// Region growing over heavy cells, heaviest cluster first.
std::vector<Cluster> Clusters(const std::vector<SymmetryWeight>& weights,
                              const So3Grid& grid,
                              const TableSymmetryParameters& parameters) {
  double heaviest = 0.0;
  for (const SymmetryWeight& one : weights) heaviest = std::max(heaviest, one.weight);
  std::map<So3Grid::Cell, double> open;
  for (const auto& [cell, weight] : weights) {
    if (weight >= parameters.heavy * heaviest) open.emplace(cell, weight);
  }
  std::vector<Cluster> clusters;
  std::vector<So3Grid::Neighbor> neighbors;
  while (!open.empty()) {
    std::vector<SymmetryWeight> members = {{open.begin()->first, open.begin()->second}};
    open.erase(open.begin());
    for (size_t i = 0; i < members.size(); ++i) {
      grid.Neighbors(members[i].cell, &neighbors);
      for (const So3Grid::Neighbor& neighbor : neighbors) {
        const auto found = open.find(neighbor.cell);
        if (found == open.end()) continue;
        members.push_back({found->first, found->second});
        open.erase(found);
      }
    }
    const Cluster cluster = ShapeOf(members, grid);
    if (cluster.weight >= parameters.least_weight) clusters.push_back(cluster);
  }
  std::stable_sort(clusters.begin(), clusters.end(), [](const Cluster& a, const Cluster& b) {
    return a.weight > b.weight;
  });
  return clusters;
}

// Share of the viewing directions whose detections fall as often into a cluster as a symmetry's
// would: at least half as often as its share of the clusters' weight, of those with few not judged.
double ShareOfDirections(const ContingencyTable& table, const Cluster& cluster, double share) {
  constexpr int kFewest = 5;  // Detections.
  int judged = 0;
  int seen = 0;
  for (const DirectionTrials& direction : table.directions) {
    int all = 0;
    int here = 0;
    for (const DifferenceCount& difference : direction.differences) {
      const Eigen::Quaterniond q = difference.Difference();
      all += difference.count;
      if (cluster.AngleTo(q) >= kSame) continue;
      const bool is_none = GeodesicAngle(q, Eigen::Quaterniond::Identity()) < 2.0 * kSame;
      if (cluster.shape == Cluster::Shape::kPoint || !is_none) here += difference.count;
    }
    if (all < kFewest) continue;
    ++judged;
    seen += static_cast<double>(here) >= std::max(1.0, 0.25 * share * all) ? 1 : 0;
  }
  return judged == 0 ? 0.0 : static_cast<double>(seen) / judged;
}

// The mean of all differences near a cluster's rotation, and their share, without the cells'
// coarseness.
void Sharpen(const ContingencyTable& table, Cluster* cluster) {
  if (cluster->shape != Cluster::Shape::kPoint) return;
  std::vector<WeightedOrientation> near;
  double sum = 0.0;
  double directions = 0.0;
  for (const DirectionTrials& direction : table.directions) {
    const int32_t detected = direction.trials - direction.missed;
    if (detected <= 0) continue;
    directions += 1.0;
    for (const DifferenceCount& difference : direction.differences) {
      const Eigen::Quaterniond q = difference.Difference();
      if (cluster->AngleTo(q) >= kSame) continue;
      near.push_back({q, static_cast<double>(difference.count) / detected});
      sum += near.back().weight;
    }
  }
  if (near.empty()) return;
  cluster->rotation = WeightedMean(near);
  cluster->weight = sum / directions;
}

struct JudgedCluster {
  Cluster cluster;
  double directions;  // Share.
};

bool IsIdentity(const Cluster& cluster) {
  return cluster.shape == Cluster::Shape::kPoint &&
         cluster.AngleTo(Eigen::Quaterniond::Identity()) < kSame;
}

// The axis of a circle of rotations that holds the identity.
std::optional<Eigen::Vector3d> AxisOfCircle(const Cluster& cluster) {
  if (cluster.shape != Cluster::Shape::kCircle) return std::nullopt;
  if (cluster.AngleTo(Eigen::Quaterniond::Identity()) > kSame) return std::nullopt;
  // Of the plane of quaternions the one without w.
  const Eigen::Matrix<double, 4, 2> plane = cluster.directions.rightCols<2>();
  const Eigen::Vector2d mix(plane(3, 1), -plane(3, 0));
  const Eigen::Vector3d axis = (plane * mix).head<3>();
  return axis.normalized();
}

bool IsFlipOf(const Cluster& cluster, const Eigen::Vector3d& axis) {
  if (cluster.shape != Cluster::Shape::kCircle) return false;
  const Eigen::Vector3d across = axis.unitOrthogonal();
  for (const Eigen::Vector3d& u : {across, Eigen::Vector3d(axis.cross(across))}) {
    if (cluster.AngleTo(Eigen::Quaterniond(0.0, u.x(), u.y(), u.z())) > kSame) return false;
  }
  return true;
}

void AddConfusion(const JudgedCluster& judged, FoundSymmetry* found) {
  if (IsIdentity(judged.cluster)) return;
  found->confusions.push_back({judged.cluster.rotation, judged.cluster.weight, judged.directions});
}

// From the heaviest on, each joins when all products are there.
void AddFinite(const std::vector<JudgedCluster>& clusters,
               const TableSymmetryParameters& parameters,
               FoundSymmetry* found) {
  std::vector<Eigen::Quaterniond> known;
  for (const JudgedCluster& one : clusters) {
    if (one.directions >= parameters.directions) known.push_back(one.cluster.rotation);
  }
  const auto find = [&known](const Eigen::Quaterniond& q) -> std::optional<Eigen::Quaterniond> {
    const std::optional<size_t> index = FindElement(known, q, kSame);
    if (!index) return std::nullopt;
    return known[*index];
  };
  std::vector<Eigen::Quaterniond> group = {Eigen::Quaterniond::Identity()};
  for (const Eigen::Quaterniond& rotation : known) {
    if (FindElement(group, rotation, kSame)) continue;
    const auto joined = JoinGroup(group, rotation, kSame, find);
    if (joined) group = *joined;
  }
  MakeExact(&group, kSame);
  std::vector<double> confidence(group.size(), 1.0);
  for (const JudgedCluster& one : clusters) {
    const std::optional<size_t> element = FindElement(group, one.cluster.rotation, kSame);
    if (!element) {
      AddConfusion(one, found);
      found->confidence = std::min(found->confidence, 1.0 - 0.5 * one.directions);
    } else if (*element != 0) {
      confidence[*element] = one.directions;
      found->confidence = std::min(found->confidence, one.directions);
    }
  }
  found->group.elements = group;
  found->axes = AxesOf(found->group, confidence);
  if (!found->axes.empty()) found->group.axis = found->axes.front().direction;
}

}  // namespace

Result<void> TableSymmetryParameters::Validate() const {
  const auto check = [](const char* name, double value) -> Result<void> {
    if (value > 0.0 && value < 1.0) return {};
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s = %g, expected above 0 and below 1", name, value)};
  };
  if (k < 2 || k > 32) {
    return Error{ErrorCode::kInvalidArgument, Format("k = %d, expected 2 to 32", k)};
  }
  if (const Result<void> valid = check("heavy", heavy); !valid) return valid;
  if (const Result<void> valid = check("least_weight", least_weight); !valid) return valid;
  return check("directions", directions);
}

Result<FoundSymmetry> SymmetryOfTable(const ContingencyTable& table,
                                      const TableSymmetryParameters& parameters) {
  if (const Result<void> valid = parameters.Validate(); !valid) return valid.error();
  if (table.directions.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "the table of " + table.key.model_id +
                     " has no trials by direction, expected them: a symmetry is what is confused "
                     "from every direction"};
  }
  const So3Grid grid(parameters.k);
  ContingencyTable by_direction;
  by_direction.key = table.key;
  by_direction.directions = table.directions;
  const Result<std::vector<SymmetryWeight>> weights = TableSymmetryWeights(by_direction, grid);
  if (!weights) return weights.error();

  FoundSymmetry found;
  std::vector<JudgedCluster> clusters;
  for (Cluster& cluster : Clusters(*weights, grid, parameters)) {
    Sharpen(table, &cluster);
    clusters.push_back({cluster, ShareOfDirections(table, cluster, cluster.weight)});
  }
  for (const JudgedCluster& one : clusters) {
    if (one.directions < parameters.directions) continue;
    if (one.cluster.shape == Cluster::Shape::kBall) {
      found.is_sphere = true;
      found.group = SymmetryGroup::Continuous(Eigen::Vector3d::UnitZ(), true);
      found.confidence = one.directions;
      return found;
    }
    const std::optional<Eigen::Vector3d> axis = AxisOfCircle(one.cluster);
    if (!axis) continue;
    double of_flips = 0.0;
    for (const JudgedCluster& other : clusters) {
      if (IsFlipOf(other.cluster, *axis)) of_flips = other.directions;
    }
    const bool flips = of_flips >= parameters.directions;
    found.group = SymmetryGroup::Continuous(*axis, flips);
    found.axes = AxesOf(found.group, {one.directions, of_flips});
    found.confidence = std::min(one.directions, flips ? of_flips : 1.0 - 0.5 * of_flips);
    for (const JudgedCluster& other : clusters) {
      if (&other == &one || (flips && IsFlipOf(other.cluster, *axis))) continue;
      AddConfusion(other, &found);
    }
    return found;
  }
  AddFinite(clusters, parameters, &found);
  return found;
}

}  // namespace vantage
