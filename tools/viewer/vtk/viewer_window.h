#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/support/png_image.h"
#include "tools/viewer/viewer_scene.h"
#include "tools/viewer/window_page.h"

namespace vantage {

/// The window, on the screen or off it. An X server is there (DISPLAY).
class ViewerWindow {
 public:
  ViewerWindow(int width, int height, bool is_offscreen);
  ~ViewerWindow();
  ViewerWindow(const ViewerWindow&) = delete;
  ViewerWindow& operator=(const ViewerWindow&) = delete;

  /// @param page as wide and high as the window. Off the screen it is drawn by Grab().
  void Show(const ViewerScene& scene, const Page& page);
  /// Turns the wide view so that it holds points (m, world), from the usual side.
  void LookAtOverview(const std::vector<Eigen::Vector3d>& points);
  /// The same of the close one.
  void LookAtCloseup(const std::vector<Eigen::Vector3d>& points);
  /// What is on it.
  [[nodiscard]] RgbImage Grab();
  [[nodiscard]] int width() const;
  [[nodiscard]] int height() const;

  struct Handlers {
    std::function<void(const std::string& key)> on_key;  ///< X's name of it, e.g. "Left", "o"
    std::function<void()> on_tick;                       ///< about 30 times a second
    std::function<void(double place)> on_slider;         ///< [0, 1], the user's
  };
  /// Shows it until Close() or until the user closes it.
  void Run(const Handlers& handlers, bool with_slider);
  void Close();
  /// Where the slider stands, [0, 1].
  void SetSlider(double place);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vantage
