#include "fusion/symmetry/turned_surface.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "common/check.h"
#include "common/rng.h"
#include "common/so3.h"

namespace vantage {
namespace {

constexpr size_t kTableSize = 33;
constexpr double kHalf = 0.5 * (kTableSize - 1);

TriangleMesh Centered(const TriangleMesh& mesh, const Eigen::Vector3d& centroid) {
  TriangleMesh centered = mesh;
  for (Eigen::Vector3f& vertex : centered.vertices) vertex -= centroid.cast<float>();
  return centered;
}

}  // namespace

TurnedSurface::TurnedSurface(const TriangleMesh& mesh, int num_samples, uint64_t seed)
    : centroid_(mesh.SurfaceCentroid()),
      diameter_(mesh.Diameter()),
      surface_(Centered(mesh, centroid_)) {
  VANTAGE_CHECK(num_samples >= 50, "samples of a surface");
  Rng rng(seed);
  samples_ = SampleSurface(Centered(mesh, centroid_), static_cast<size_t>(num_samples), rng);
  Tabulate();
}

double TurnedSurface::At(size_t i) const { return reach_ * (static_cast<double>(i) / kHalf - 1.0); }

void TurnedSurface::Tabulate() {
  for (const SurfacePoint& sample : samples_) {
    reach_ = std::max(reach_, static_cast<double>(sample.position.norm()));
  }
  table_.reserve(kTableSize * kTableSize * kTableSize);
  for (size_t x = 0; x < kTableSize; ++x) {
    for (size_t y = 0; y < kTableSize; ++y) {
      for (size_t z = 0; z < kTableSize; ++z) {
        const Eigen::Vector3d place(At(x), At(y), At(z));
        // The nearest to the place before it can't be much farther than the nearest.
        const double reach =
            table_.empty() ? 1e3 * diameter_ : (table_.back().point - place).norm() + 1e-6 * reach_;
        table_.push_back(surface_.NearestWithin(place, reach));
      }
    }
  }
}

const NearestSurface::Hit& TurnedSurface::TabulatedHit(const Eigen::Vector3d& point) const {
  size_t index = 0;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double place = std::round((point[i] / reach_ + 1.0) * kHalf);
    index = index * kTableSize + static_cast<size_t>(std::clamp(place, 0.0, 2.0 * kHalf));
  }
  return table_[index];
}

double TurnedSurface::TabulatedDistance(const Eigen::Vector3d& point) const {
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
      index = index * kTableSize + low[i] + step;
    }
    sum += weight * table_[index].distance;
  }
  return sum;
}

double TurnedSurface::CoarseMse(const Motion& motion) const {
  constexpr size_t kUsed = 300;
  const size_t stride = std::max<size_t>(1, samples_.size() / kUsed);
  double sum = 0.0;
  double count = 0.0;
  for (size_t i = 0; i < samples_.size(); i += stride) {
    const double distance =
        TabulatedDistance(motion.linear * samples_[i].position.cast<double>() + motion.shift);
    sum += distance * distance;
    count += 1.0;
  }
  return sum / count;
}

double TurnedSurface::Mse(const Motion& motion) const {
  const double farthest = 0.1 * diameter_;
  const Eigen::Matrix3d back = motion.linear.transpose();
  double sum = 0.0;
  const auto add = [&](const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
    const double distance =
        std::min(farthest, surface_.NearestFacing(point, normal, farthest).distance);
    sum += distance * distance;
  };
  for (const SurfacePoint& sample : samples_) {
    const Eigen::Vector3d position = sample.position.cast<double>();
    const Eigen::Vector3d normal = sample.normal.cast<double>();
    add(motion.linear * position + motion.shift, motion.linear * normal);
    add(back * (position - motion.shift), back * normal);
  }
  return sum / static_cast<double>(2 * samples_.size());
}

// `find` gives the nearest place of the surface to a point, and the weight that it has.
template <class FindHit>
TurnedSurface::Motion TurnedSurface::Descend(Motion motion,
                                             int num_used,
                                             const FindHit& find) const {
  using Matrix6d = Eigen::Matrix<double, 6, 6>;
  using Vector6d = Eigen::Matrix<double, 6, 1>;
  constexpr int kSteps = 12;
  constexpr double kLongest = 10.0 * kDegree;
  const size_t stride = std::max<size_t>(1, samples_.size() / static_cast<size_t>(num_used));
  for (int step = 0; step < kSteps; ++step) {
    Matrix6d normal_matrix = Matrix6d::Zero();
    Vector6d right_side = Vector6d::Zero();
    for (size_t i = 0; i < samples_.size(); i += stride) {
      const Eigen::Vector3d turned = motion.linear * samples_[i].position.cast<double>();
      const Eigen::Vector3d point = turned + motion.shift;
      const auto [hit, weight] = find(point);
      Vector6d jacobian;
      jacobian << (turned / diameter_).cross(hit.normal), hit.normal;
      normal_matrix.selfadjointView<Eigen::Lower>().rankUpdate(jacobian, weight);
      right_side -= weight * jacobian * hit.normal.dot(point - hit.point) / diameter_;
    }
    // Damped: along a continuous symmetry nothing changes.
    normal_matrix.diagonal().array() += 1e-5 * normal_matrix.trace() + 1e-30;
    Vector6d change = normal_matrix.selfadjointView<Eigen::Lower>().ldlt().solve(right_side);
    const double angle = change.head<3>().norm();
    if (angle > kLongest) change *= kLongest / angle;
    motion.linear = ExpSo3(change.head<3>()).toRotationMatrix() * motion.linear;
    motion.shift += diameter_ * change.tail<3>();
    if (change.norm() < 1e-5) break;
  }
  return motion;
}

namespace {
struct WeightedHit {
  NearestSurface::Hit hit;
  double weight;
};
}  // namespace

TurnedSurface::Motion TurnedSurface::RegisterCoarsely(const Motion& near, int num_used) const {
  return Descend(near, num_used, [this](const Eigen::Vector3d& point) {
    return WeightedHit{TabulatedHit(point), 1.0};
  });
}

TurnedSurface::Motion TurnedSurface::Register(const Motion& near, int num_used) const {
  const double outlying = 0.02 * diameter_;
  return Descend(RegisterCoarsely(near, num_used), num_used, [&](const Eigen::Vector3d& point) {
    const double reach = (TabulatedHit(point).point - point).norm() + 1e-6 * reach_;
    const NearestSurface::Hit hit = surface_.NearestWithin(point, reach);
    const double ratio = hit.distance / outlying;
    return WeightedHit{hit, 1.0 / ((1.0 + ratio * ratio) * (1.0 + ratio * ratio))};
  });
}

}  // namespace vantage
