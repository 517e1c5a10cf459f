#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "common/triangle_mesh.h"
#include "fusion/symmetry/nearest_surface.h"

namespace vantage {

/// A mesh about its surface's centroid, moved by candidates of a symmetry and held against itself
/// (paper 6.3: "rotating the object ... and computing the point-wise mean squared error of the
/// initial model and the rotated model"). Distances are from points to triangles, so that sampling
/// adds no error.
class TurnedSurface {
 public:
  /// p -> linear * p + shift, p from the centroid, m. `linear` is a rotation, or one after a
  /// reflection.
  struct Motion {
    Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();

    static Motion About(const Eigen::Matrix3d& linear, const Eigen::Vector3d& center) {
      return {linear, center - linear * center};
    }
  };

  /// @param mesh of some area.
  /// @param num_samples points of the surface that are moved, at least 50.
  TurnedSurface(const TriangleMesh& mesh, int num_samples, uint64_t seed);

  [[nodiscard]] const Eigen::Vector3d& centroid() const { return centroid_; }  ///< m, in the mesh
  [[nodiscard]] double diameter() const { return diameter_; }                  ///< m

  /// Mean squared distance of the moved surface to the surface, m^2, from a table: to within some
  /// (0.01 diameters)^2, a hundred times as fast as Mse.
  [[nodiscard]] double CoarseMse(const Motion& motion) const;
  /// Mean squared distance of the moved surface to the surface and of the surface to the moved one,
  /// m^2; between places that face alike, none counts more than a tenth of the diameter.
  [[nodiscard]] double Mse(const Motion& motion) const;
  /// The minimum of the error near a motion: iterated Gauss-Newton steps on the distances to the
  /// tangent planes of the nearest points (Chen and Medioni 1992), rotation and translation; in the
  /// first half with the planes of a table, in the second exactly, and outliers lose weight (Geman
  /// and McClure 1985).
  /// @param num_used samples that take part.
  [[nodiscard]] Motion Register(const Motion& near, int num_used) const;
  /// The first half alone.
  [[nodiscard]] Motion RegisterCoarsely(const Motion& near, int num_used) const;

 private:
  [[nodiscard]] double At(size_t i) const;
  void Tabulate();
  [[nodiscard]] double TabulatedDistance(const Eigen::Vector3d& point) const;
  [[nodiscard]] const NearestSurface::Hit& TabulatedHit(const Eigen::Vector3d& point) const;
  template <class FindHit>
  [[nodiscard]] Motion Descend(Motion motion, int num_used, const FindHit& find) const;

  Eigen::Vector3d centroid_;
  double diameter_;
  NearestSurface surface_;
  std::vector<SurfacePoint> samples_;       // From the centroid.
  double reach_ = 0.0;                      // m, half the edge of the table's cube.
  std::vector<NearestSurface::Hit> table_;  // Nearest to the places of a lattice.
};

}  // namespace vantage
