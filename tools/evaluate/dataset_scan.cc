#include "tools/evaluate/dataset_scan.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "common/check.h"
#include "common/rng.h"
#include "common/statistics.h"
#include "perception/model/mesh_check.h"
#include "perception/model/mesh_import.h"
#include "perception/model/model_builder.h"

namespace vantage {
namespace {

constexpr size_t kSurfacePoints = 20'000;
constexpr size_t kMovedPoints = 600;
constexpr uint64_t kSeed = 1;

const SurfacePoint& Nearest(std::span<const SurfacePoint> surface, const Eigen::Vector3f& p) {
  size_t nearest = 0;
  float least = std::numeric_limits<float>::max();
  for (size_t i = 0; i < surface.size(); ++i) {
    const float squared = (surface[i].position - p).squaredNorm();
    if (squared >= least) continue;
    least = squared;
    nearest = i;
  }
  return surface[nearest];
}

// To the plane of the nearest sample, m.
double DistanceTo(std::span<const SurfacePoint> surface, const Eigen::Vector3d& point) {
  const Eigen::Vector3f p = point.cast<float>();
  const SurfacePoint& nearest = Nearest(surface, p);
  return static_cast<double>(std::abs(nearest.normal.dot(p - nearest.position)));
}

// Columns are the axes, that of the least spread first.
Eigen::Matrix3d PrincipalAxes(std::span<const SurfacePoint> surface,
                              const Eigen::Vector3d& center) {
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  for (const SurfacePoint& point : surface) {
    const Eigen::Vector3d p = point.position.cast<double>() - center;
    moments += p * p.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(moments).eigenvectors();
}

}  // namespace

Result<ObjectModel> LoadScan(const std::string& id, const std::filesystem::path& file) {
  Result<TriangleMesh> mesh = ImportMesh(file, 1.0);
  if (!mesh) return mesh.error();
  const Result<MeshMending> mended = CheckAndMendMesh(&*mesh);
  if (!mended) return Error{mended.error().code, file.string() + ": " + mended.error().message};
  const SymmetryGroup symmetry = MeasureSymmetry(*mesh);
  return BuildObjectModel(id, std::move(mesh).value(), symmetry, file.filename().string(), {});
}

SymmetryGroup MeasureSymmetry(const TriangleMesh& mesh) {
  Rng rng(kSeed);
  const std::vector<SurfacePoint> surface = SampleSurface(mesh, kSurfacePoints, rng);
  const std::vector<SurfacePoint> moved = SampleSurface(mesh, kMovedPoints, rng);
  const Eigen::Vector3d center = mesh.SurfaceCentroid();
  const double tolerance = 0.015 * mesh.Diameter();
  const auto maps_onto_itself = [&](const Eigen::Vector3d& axis, double angle) {
    const Eigen::AngleAxisd turn(angle, axis);
    std::vector<double> distances;
    for (const SurfacePoint& point : moved) {
      const Eigen::Vector3d p = point.position.cast<double>() - center;
      distances.push_back(DistanceTo(surface, turn * p + center));
    }
    return Quantile(distances, 0.95) <= tolerance;
  };
  const Eigen::Matrix3d axes = PrincipalAxes(surface, center);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d axis = axes.col(i);
    if (maps_onto_itself(axis, 37.0 * kDegree) && maps_onto_itself(axis, 101.0 * kDegree)) {
      return SymmetryGroup::Continuous(axis,
                                       maps_onto_itself(axes.col((i + 1) % 3), std::numbers::pi));
    }
  }
  std::vector<Eigen::Vector3d> half_turns;
  for (int i = 0; i < 3; ++i) {
    if (maps_onto_itself(axes.col(i), std::numbers::pi)) half_turns.emplace_back(axes.col(i));
  }
  if (half_turns.empty()) return SymmetryGroup::None();
  if (half_turns.size() == 1) return SymmetryGroup::Cyclic(2, half_turns[0]);
  return SymmetryGroup::Dihedral(2, half_turns[0], half_turns[1]);
}

ScanAlignment AlignToScan(std::span<const Eigen::Vector3d> points,
                          const TriangleMesh& mesh,
                          const Pose& T_mesh_points_start) {
  VANTAGE_CHECK(!points.empty(), "no points to align");
  constexpr int kIterations = 15;
  constexpr double kReach = 0.01;    // m, of the first pairs
  constexpr double kFloor = 0.002;   // m, of the last
  constexpr double kDamping = 1e-6;  // Of what the shape leaves open, such as a can's turn.
  Rng rng(kSeed);
  const std::vector<SurfacePoint> surface = SampleSurface(mesh, kSurfacePoints, rng);
  const size_t step = std::max<size_t>(1, points.size() / kMovedPoints);
  ScanAlignment result{T_mesh_points_start, 0.0};
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const double reach = std::max(kFloor, kReach * std::pow(0.7, iteration));
    Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
    for (size_t i = 0; i < points.size(); i += step) {
      const Eigen::Vector3d p = result.T_mesh_points * points[i];
      const SurfacePoint& nearest = Nearest(surface, p.cast<float>());
      const Eigen::Vector3d n = nearest.normal.cast<double>();
      const double distance = n.dot(p - nearest.position.cast<double>());
      if (std::abs(distance) > reach) continue;
      Eigen::Matrix<double, 6, 1> row;
      row << p.cross(n), n;
      A += row * row.transpose();
      b -= distance * row;
    }
    A.diagonal().array() += kDamping * A.trace();
    const Eigen::Matrix<double, 6, 1> motion = A.ldlt().solve(b);
    Pose step_pose(ExpSo3(motion.head<3>()));
    step_pose.translation() = motion.tail<3>();
    result.T_mesh_points = step_pose * result.T_mesh_points;
  }
  std::vector<double> distances;
  for (size_t i = 0; i < points.size(); i += step) {
    distances.push_back(DistanceTo(surface, result.T_mesh_points * points[i]));
  }
  result.median = Median(distances);
  return result;
}

}  // namespace vantage
