#pragma once

#include <cstdint>
#include <string>

#include "common/result.h"
#include "common/so3.h"

namespace vantage {

/// A structured-light depth sensor (Asus Xtion, Kinect 1, Carmine). Each part can be switched off;
/// with every part off the depth is the ideal one. Disparities are in px of the 640 px wide image.
///
/// Sources: [KE] Khoshelham and Elberink, "Accuracy and Resolution of Kinect Depth Data for Indoor
/// Mapping Applications", Sensors 2012. [N] Nguyen, Izadi and Lovell, "Modeling Kinect Sensor Noise
/// for Improved 3D Reconstruction and Tracking", 3DIMPVT 2012. [KM] Konolige and Mihelich,
/// "Technical description of Kinect calibration", 2010.
struct SensorModelParameters {
  uint64_t seed = 1;       ///< Of all noise.
  uint64_t device_id = 0;  ///< Decides the bias: a device keeps its own. See DeviceIdFromSerial.

  double baseline = 0.075;  ///< m, projector right of the camera [KE: 75 mm]
  double nearest = 0.4;     ///< m, nothing is measured nearer
  double farthest = 4.0;    ///< m, nor beyond

  /// Disparities are multiples of a step; in depth z^2 step / (f b): 2.9 mm at 1 m [KM, KE].
  bool quantization = true;
  double disparity_step = 0.125;  ///< px [KM: 1/8 px]

  /// Noise of the disparity, so that sigma_z grows with z^2 [KE: sigma_z = 1.425e-3 z^2 m, from
  /// 0.5 steps of disparity noise]. That figure was measured after quantisation, which alone gives
  /// 1/sqrt(12) step; what is left for the noise itself is sqrt(0.25 - 1/12) = 0.41 steps.
  bool axial_noise = true;
  double axial_sigma = 0.051;  ///< px
  /// Added at grazing angles t beyond 60 degrees: 1e-4 z^-1/2 t^2 / (pi/2 - t)^2 m [N].
  double grazing_sigma = 1e-4;  ///< m^(3/2)
  /// Neighbouring pixels share most of their 9 x 9 px matching window [KM], so noise is smooth: a
  /// Gaussian of this sigma. Independent noise would average out over an object.
  double correlation = 1.5;  ///< px

  /// Where a pixel looks wanders: (0.8 + 0.035 t / (pi/2 - t)) px [N], t being the angle of
  /// incidence. Seen at edges only: on smooth surfaces it is part of the axial noise as measured.
  bool lateral_noise = true;
  double lateral_sigma = 0.8;          ///< px
  double lateral_sigma_angle = 0.035;  ///< px
  double edge_step = 1.0;              ///< px, disparity step taken for an edge within one surface

  /// What the projector cannot see has no pattern and no depth: left of a near edge a strip of
  /// b f (1 / z_near - 1 / z_far) px is lost [KE].
  bool shadow = true;

  /// Surfaces seen at a slant reflect too little pattern [N: its measurements end near 80 deg].
  bool grazing_dropout = true;
  double dropout_start = 75.0 * kDegree;  ///< rad, none dropped up to here
  double dropout_end = 88.0 * kDegree;    ///< rad, all dropped from here; linear between

  /// Distortion that calibration leaves: smooth over the image and over disparity, growing with z^2
  /// (a disparity error), the device's own, drifting as it warms. Herrera, Kannala and Heikkila,
  /// "Joint depth and color camera calibration with distortion correction", PAMI 2012; Teichman,
  /// Miller and Thrun, "Unsupervised intrinsic calibration of depth sensors via SLAM", RSS 2013.
  bool bias = true;
  double bias_at_1m = 0.001;   ///< m, largest at z = 1 m
  double bias_period = 600.0;  ///< s, in which the field changes wholly

  /// Switches every part off; range limits stay.
  void SwitchAllOff();
  Result<void> Validate() const;
};

/// FNV-1a of a serial number.
uint64_t DeviceIdFromSerial(const std::string& serial);

}  // namespace vantage
