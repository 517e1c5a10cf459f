#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "common/result.h"
#include "common/triangle_mesh.h"
#include "perception/ppf/point_pair_feature.h"

namespace vantage {

struct PpfTableParameters {
  double sample_distance = 0.05;  ///< of the diameter, between points (Drost et al. 2010: 0.05)
  double distance_step = 0.05;    ///< of the diameter, bin of |d| (Drost et al. 2010: 0.05)
  double angle_step_deg = 12.0;   ///< deg, bin of the angles (Drost et al. 2010: 360 / 30)
  int max_points = 2000;          ///< the table grows with the square
  Result<void> Validate() const;
  bool operator==(const PpfTableParameters&) const = default;
};

/// All pairs of a model's surface points by their quantised point pair feature (paper section 3.1;
/// Drost et al. 2010): a direct index over the four bins, no hashing and so no collisions.
class PpfTable {
 public:
  /// A pair of model points: the first of it, and the turn about x of the second (AngleAboutX) in
  /// units of 2 pi / 65536, which wrap around.
  struct Entry {
    uint16_t reference;
    uint16_t angle;
    bool operator==(const Entry&) const = default;
  };
  /// Bins of distance, angle_normal1, angle_normal2, angle_normals.
  using Bins = std::array<int, 4>;

  /// Thins `samples` to `sample_distance` and stores every ordered pair of what is left.
  /// Errors: parameters, fewer than 3 points left, a point that is not finite, diameter not
  /// positive.
  static Result<PpfTable> Train(std::span<const SurfacePoint> samples,
                                double diameter,
                                const PpfTableParameters& parameters);
  /// Writes a file that belongs to a mesh, whole or not at all.
  Result<void> Save(const std::filesystem::path& file, uint64_t mesh_hash) const;
  /// Errors: no such file, no table, of another version, mesh or machine, inconsistent in itself.
  static Result<PpfTable> Load(const std::filesystem::path& file, uint64_t mesh_hash);

  [[nodiscard]] Bins Quantize(const PointPairFeature& feature) const;
  /// Where in its bins a feature lies, in bins, not rounded: Quantize is its floor.
  [[nodiscard]] std::array<float, 4> Scale(const PointPairFeature& feature) const;
  /// The pairs of a cell; empty when a bin is outside the table.
  [[nodiscard]] std::span<const Entry> Lookup(const Bins& bins) const;

  [[nodiscard]] std::span<const SurfacePoint> points() const { return points_; }
  [[nodiscard]] double diameter() const { return diameter_; }
  [[nodiscard]] const PpfTableParameters& parameters() const { return parameters_; }
  [[nodiscard]] size_t num_entries() const { return entries_.size(); }

  [[nodiscard]] int distance_bins() const { return distance_bins_; }
  [[nodiscard]] int angle_bins() const { return angle_bins_; }
  [[nodiscard]] float distance_scale() const { return distance_scale_; }  ///< bins/m
  [[nodiscard]] float angle_scale() const { return angle_scale_; }        ///< bins/rad
  /// Of bins inside the table, ((distance * n + angle_normal1) * n + angle_normal2) * n +
  /// angle_normals with n = angle_bins().
  [[nodiscard]] size_t Cell(const Bins& bins) const;
  /// Where each cell begins in entries(), and the end.
  [[nodiscard]] std::span<const uint32_t> starts() const { return starts_; }
  [[nodiscard]] std::span<const Entry> entries() const { return entries_; }

 private:
  PpfTable() = default;
  void SetScale();
  [[nodiscard]] size_t NumCells() const;
  [[nodiscard]] Result<void> CheckConsistent() const;

  PpfTableParameters parameters_;
  double diameter_ = 0.0;  // m
  std::vector<SurfacePoint> points_;
  std::vector<uint32_t> starts_;  // Of each cell in entries_, and the end.
  std::vector<Entry> entries_;
  int distance_bins_ = 0;
  int angle_bins_ = 0;
  float distance_scale_ = 0.0F;  // 1/m
  float angle_scale_ = 0.0F;     // 1/rad
};

/// An angle (rad) in the units of PpfTable::Entry::angle.
uint16_t QuantizeTurn(float angle);

/// Of `samples` in their order those at least `distance` m from all that were taken before, where
/// points whose normals differ by more than `angle` rad don't count as near.
std::vector<SurfacePoint> ThinSamples(std::span<const SurfacePoint> samples,
                                      double distance,
                                      double angle,
                                      size_t max_points);

}  // namespace vantage
