#include "perception/model/surface_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "common/depth_rasterizer.h"
#include "common/format.h"

namespace vantage {
namespace {

// A place on the surface, before it is known whether it becomes a sample.
struct Candidate {
  Eigen::Vector3f position;
  Eigen::Vector3f normal;       // of the smooth surface
  Eigen::Vector3f face_normal;  // of its triangle
};

// How often a candidate was seen from either side.
struct Sightings {
  int front = 0;
  int back = 0;
};

std::vector<Candidate> ThrowCandidates(const TriangleMesh& mesh,
                                       double crease,
                                       size_t count,
                                       Rng& rng) {
  const std::vector<std::array<Eigen::Vector3f, 3>> normals = CornerNormals(mesh, crease);
  std::vector<double> cumulative(mesh.triangles.size());
  double total = 0.0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    total += static_cast<double>(mesh.ScaledNormal(i).norm());
    cumulative[i] = total;
  }
  std::vector<Candidate> candidates(count);
  for (Candidate& candidate : candidates) {
    const double pick = rng.Uniform() * total;
    const auto found = std::upper_bound(cumulative.begin(), cumulative.end(), pick);
    const size_t triangle =
        std::min(static_cast<size_t>(found - cumulative.begin()), cumulative.size() - 1);
    const auto root = static_cast<float>(std::sqrt(rng.Uniform()));
    const auto along = static_cast<float>(rng.Uniform());
    const std::array<float, 3> weights = {1.0F - root, root * (1.0F - along), root * along};
    Eigen::Vector3f position = Eigen::Vector3f::Zero();
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    for (size_t corner = 0; corner < 3; ++corner) {
      position += weights[corner] * mesh.vertices[mesh.triangles[triangle][corner]];
      normal += weights[corner] * normals[triangle][corner];
    }
    candidate = {position, normal.normalized(), mesh.ScaledNormal(triangle).normalized()};
  }
  return candidates;
}

// Looks at the mesh from far away along directions of a Fibonacci lattice and notes which
// candidates the depth buffer shows, and from which side.
std::vector<Sightings> Look(const TriangleMesh& mesh,
                            double diameter,
                            const SurfaceSampleParameters& parameters,
                            const std::vector<Candidate>& candidates) {
  const Eigen::Vector3d middle = mesh.Bounds().center().cast<double>();
  const double distance = 20.0 * diameter + 1.0;
  CameraModel camera;
  camera.width = parameters.image_size;
  camera.height = parameters.image_size;
  // The sphere about the middle that holds the mesh has a radius of at most 0.87 diameters.
  camera.fx = parameters.image_size * distance / (1.8 * diameter);
  camera.fy = camera.fx;
  camera.cx = 0.5 * (camera.width - 1);
  camera.cy = 0.5 * (camera.height - 1);
  const double pixel = distance / camera.fx;  // m, on the surface
  constexpr double kLeastCosine = 0.2;        // Flatter looks say little in whole pixels.

  std::vector<Sightings> sightings(candidates.size());
  DepthRasterizer rasterizer(camera);
  for (int i = 0; i < parameters.directions; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / parameters.directions;
    const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    const Eigen::Vector3d direction(r * std::cos(angle), r * std::sin(angle), z);
    const Pose T_mesh_camera = LookAt(middle + distance * direction, middle);
    const Pose T_camera_mesh = T_mesh_camera.inverse();
    rasterizer.Clear();
    rasterizer.Draw(mesh, T_camera_mesh);
    for (size_t j = 0; j < candidates.size(); ++j) {
      const double cosine = candidates[j].face_normal.cast<double>().dot(direction);
      if (std::abs(cosine) < kLeastCosine) continue;
      const Eigen::Vector3d p_camera = T_camera_mesh * candidates[j].position.cast<double>();
      const Eigen::Vector2d uv = camera.Project(p_camera);
      const auto u = static_cast<int>(std::lround(uv.x()));
      const auto v = static_cast<int>(std::lround(uv.y()));
      if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) continue;
      const size_t index =
          static_cast<size_t>(v) * static_cast<size_t>(camera.width) + static_cast<size_t>(u);
      const auto depth = static_cast<double>(rasterizer.depth()[index]);
      // Half a pixel's diagonal aside, the surface lies this much deeper or nearer; and float
      // depth at this distance has a grain.
      const double slope = std::sqrt(1.0 - cosine * cosine) / std::abs(cosine);
      const double tolerance = 0.71 * pixel * slope + 2e-6 * distance + 0.05 * pixel;
      if (!(p_camera.z() < depth + tolerance)) continue;
      ++(cosine > 0.0 ? sightings[j].front : sightings[j].back);
    }
  }
  return sightings;
}

// Keeps the points taken so far in cubes of the spacing's size.
class SpacedPoints {
 public:
  explicit SpacedPoints(double spacing) : spacing_(static_cast<float>(spacing)) {}

  // Points on opposite sides of a thin wall do not crowd each other.
  [[nodiscard]] bool HasRoom(const SurfacePoint& point) const {
    constexpr float kOtherSide = -0.5F;  // cosine of the normals' angle
    const Eigen::Vector3i cell = CellOf(point.position);
    for (int i = 0; i < 27; ++i) {
      const auto found =
          cells_.find(Key(cell + Eigen::Vector3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)));
      if (found == cells_.end()) continue;
      for (const size_t index : found->second) {
        const SurfacePoint& other = points_[index];
        if ((other.position - point.position).norm() < spacing_ &&
            other.normal.dot(point.normal) > kOtherSide) {
          return false;
        }
      }
    }
    return true;
  }
  void Add(const SurfacePoint& point) {
    cells_[Key(CellOf(point.position))].push_back(points_.size());
    points_.push_back(point);
  }
  std::vector<SurfacePoint> Take() { return std::move(points_); }

 private:
  [[nodiscard]] Eigen::Vector3i CellOf(const Eigen::Vector3f& position) const {
    return (position / spacing_).array().floor().cast<int>();
  }
  static uint64_t Key(const Eigen::Vector3i& cell) {
    constexpr int kOffset = 1 << 20;  // 21 bits a coordinate
    uint64_t key = 0;
    for (const int value : cell) key = (key << 21U) | static_cast<uint64_t>(value + kOffset);
    return key;
  }

  float spacing_;
  std::vector<SurfacePoint> points_;
  std::unordered_map<uint64_t, std::vector<size_t>> cells_;
};

}  // namespace

Result<void> SurfaceSampleParameters::Validate() const {
  const auto out_of_range = [](const char* name, double value, double lowest, double highest) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("sample %s = %g, expected %g to %g", name, value, lowest, highest)};
  };
  if (!(spacing >= 0.005 && spacing <= 0.5)) return out_of_range("spacing", spacing, 0.005, 0.5);
  if (!(crease >= 0.0 && crease <= 0.5 * std::numbers::pi)) {
    return out_of_range("crease", crease, 0.0, 0.5 * std::numbers::pi);
  }
  if (directions < 1 || directions > 2000) return out_of_range("directions", directions, 1, 2000);
  if (image_size < 32 || image_size > 2048) return out_of_range("image size", image_size, 32, 2048);
  return {};
}

std::vector<std::array<Eigen::Vector3f, 3>> CornerNormals(const TriangleMesh& mesh, double crease) {
  const size_t count = mesh.triangles.size();
  std::vector<Eigen::Vector3f> scaled(count);
  std::vector<std::vector<uint32_t>> faces_of(mesh.vertices.size());
  for (size_t i = 0; i < count; ++i) {
    scaled[i] = mesh.ScaledNormal(i);
    for (const uint32_t vertex : mesh.triangles[i]) {
      faces_of[vertex].push_back(static_cast<uint32_t>(i));
    }
  }
  const auto least_cosine = static_cast<float>(std::cos(crease));
  std::vector<std::array<Eigen::Vector3f, 3>> normals(count);
  for (size_t i = 0; i < count; ++i) {
    const Eigen::Vector3f own = scaled[i].normalized();
    for (size_t corner = 0; corner < 3; ++corner) {
      Eigen::Vector3f sum = scaled[i];
      for (const uint32_t face : faces_of[mesh.triangles[i][corner]]) {
        if (face != i && scaled[face].normalized().dot(own) >= least_cosine) sum += scaled[face];
      }
      normals[i][corner] = sum.normalized();
    }
  }
  return normals;
}

std::vector<SurfacePoint> SampleVisibleSurface(const TriangleMesh& mesh,
                                               double diameter,
                                               const SurfaceSampleParameters& parameters,
                                               Rng& rng) {
  // Random packing of discs covers the plane once there are some 15 darts a disc.
  constexpr double kDarts = 15.0;
  constexpr double kMostCandidates = 1e6;
  const double spacing = parameters.spacing * diameter;
  const double discs = mesh.Area() / (spacing * spacing);
  const auto count = static_cast<size_t>(std::min(kDarts * discs + 100.0, kMostCandidates));
  const std::vector<Candidate> candidates = ThrowCandidates(mesh, parameters.crease, count, rng);
  const std::vector<Sightings> sightings = Look(mesh, diameter, parameters, candidates);
  SpacedPoints points(spacing);
  for (size_t i = 0; i < candidates.size(); ++i) {
    const auto [front, back] = sightings[i];
    if (front + back == 0) continue;
    SurfacePoint point{candidates[i].position, candidates[i].normal};
    if (back > front) point.normal = -point.normal;
    if (points.HasRoom(point)) points.Add(point);
  }
  return points.Take();
}

}  // namespace vantage
