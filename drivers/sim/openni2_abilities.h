#pragma once

#include <chrono>

namespace vantage {

/// What sets devices apart: the simulated one can be like any of them.
struct SimAbilities {
  enum class Registration {
    kWorks,    ///< depth to color
    kClaimed,  ///< said to be supported, and setting it to succeed; but it stays off
    kNone,
  };
  enum class Mirroring {
    kOff,          ///< until it is switched on
    kOn,           ///< until it is switched off, as OpenNI2's drivers have it
    kAlways,       ///< switching it off succeeds and does nothing
    kAlwaysDepth,  ///< so of depth; color as kOff
  };

  Registration registration = Registration::kWorks;
  Mirroring mirroring = Mirroring::kOff;
  bool exclusive = false;        ///< opens for one program at a time, like hardware
  bool frame_sync = false;       ///< can synchronize color with depth
  bool fine_depth = false;       ///< in 0.1 mm instead of 1 mm
  bool gray_color = false;       ///< its color is 8 bit gray
  bool full_color_only = false;  ///< color only of full resolution
  bool infrared = false;         ///< lists an infrared sensor, which gives no stream
  std::chrono::milliseconds opening_time{0};
  std::chrono::milliseconds color_delay{0};  ///< by which color is taken after its depth
};

}  // namespace vantage
