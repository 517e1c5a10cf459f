#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "drivers/sim/noise_tile.h"
#include "drivers/sim/scene_renderer.h"
#include "drivers/sim/sensor_parameters.h"

namespace vantage {

/// Turns an ideal view into what the sensor reports. The same frame of the same seed is the same
/// always, whatever was asked for before.
class SensorModel {
 public:
  static constexpr int kAlignment = 16;  ///< px

  SensorModel(const SensorModelParameters& parameters, const CameraModel& camera);

  /// Makes it another device: one of another bias and noise.
  void SetDevice(uint64_t device_id);

  /// @param view of the camera that was given. Of a window that begins at multiples of kAlignment
  /// the result is what the whole image's would hold there, but for pixels within kAlignment of the
  /// window's border that isn't the image's, and for the shadow of what is right of the window.
  /// @param time s since the device's start, for the bias.
  /// @param measured depth, m; NaN where nothing is measured. Its buffer is reused.
  void Measure(const RenderedView& view, int64_t frame, double time, DepthImage* measured);

  /// The bias alone: disparity, px, at a pixel for a true disparity and a time.
  [[nodiscard]] double BiasDisparity(double u, double v, double disparity, double time) const;

 private:
  struct BiasWave {
    double ku, kv, phase, drift;  // rad/px, rad/px, rad, rad/s
  };
  static constexpr int kBiasCell = kAlignment;
  static constexpr int kEdgeBlock = 8;        // px, also the largest shift of an edge.
  static constexpr size_t kAngleSteps = 256;  // Of the tables over cos_incidence.

  void MakeTables();
  void MakeBias();
  void Prepare(const RenderedView& view);
  [[nodiscard]] double BiasField(double u, double v, double time) const;
  // The bias's part over disparity comes in steps, by index.
  [[nodiscard]] static size_t BiasTermIndex(float disparity);
  [[nodiscard]] float BiasTerm(size_t index) const;
  void FillBiasGrid(double time);
  void FillBiasTerms();
  void AddBiasRow(int v);
  void AddNoiseRow(const RenderedView& view, int v, const NoiseTile::Window& noise);
  void DropAtGrazing(const RenderedView& view, const NoiseTile::Window& noise);
  void CastShadows();
  void CastRowShadows(std::span<float> row);
  void FindEdges(const RenderedView& view);
  [[nodiscard]] bool EdgeNear(int column, int row) const;
  void ShiftEdges(const RenderedView& view,
                  const NoiseTile::Window& along_u,
                  const NoiseTile::Window& along_v);
  void ShiftPixels(const RenderedView& view,
                   int u0,
                   int u1,
                   int v,
                   const NoiseTile::Window& along_u,
                   const NoiseTile::Window& along_v);
  void MeasureRow(const RenderedView& view, int v, float* out) const;
  [[nodiscard]] int EdgeColumns() const { return (window_.width() - 1) / kEdgeBlock + 1; }
  [[nodiscard]] int EdgeRows() const { return (window_.height() - 1) / kEdgeBlock + 1; }

  SensorModelParameters parameters_;
  CameraModel camera_;
  PixelWindow window_;     // Of the view in hand; rows and columns are counted from its corner.
  double focal_baseline_;  // px m, at 640 px
  double vga_scale_;       // px of the 640 px image in one px of ours
  NoiseTile tile_;
  std::vector<BiasWave> bias_waves_;
  double bias_amplitude_ = 0.0;  // px
  double bias_phase_ = 0.0;      // rad, of the part over disparity
  // Over cos_incidence: lateral sigma, px; grazing sigma, m^(3/2); threshold of dropout.
  std::vector<float> lateral_table_, grazing_table_, dropout_table_;
  // Reused.
  std::vector<float> disparity_, observed_, projector_, bias_grid_, bias_terms_;
  std::vector<float> offset_row_, noise_row_, sigma_row_;
  std::vector<int> projector_column_, shift_u_row_, shift_v_row_;
  std::vector<uint8_t> edge_blocks_;
};

}  // namespace vantage
