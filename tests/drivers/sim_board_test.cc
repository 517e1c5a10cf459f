// The printed board in color and depth.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/statistics.h"
#include "drivers/sim/board_painter.h"
#include "drivers/sim/shading.h"
#include "drivers/sim/sim_camera.h"

namespace vantage {
namespace {

constexpr int kPrint = 400;  // px, along each side

/// Black where x < 0, white elsewhere.
SimBoard HalfBlack() {
  SimBoard board;
  board.print = GrayImage(kPrint, kPrint, 255);
  for (int v = 0; v < kPrint; ++v) {
    for (int u = 0; u < kPrint / 2; ++u) board.print.at(u, v) = 0;
  }
  board.noise = 0.0;
  return board;
}

struct Picture {
  RenderedView view;
  uint32_t board = 0;
  std::vector<uint8_t> rgb;

  [[nodiscard]] double at(int u, int v) const {
    return rgb[3 * (static_cast<size_t>(v) * static_cast<size_t>(view.camera.width) +
                    static_cast<size_t>(u))];
  }
};

Picture Take(const SimBoard& board, const Pose& T_world_camera, int64_t frame = 0) {
  SimScene scene;
  scene.board = board;
  SceneRenderer renderer(scene, CameraModel{});
  Picture picture{renderer.Render(T_world_camera), renderer.Board(), {}};
  ShadeColor(picture.view, &picture.rgb);
  BoardPainter painter(board, 5);
  painter.Paint(picture.view, T_world_camera, picture.board, frame, &picture.rgb);
  return picture;
}

double Deviation(const std::vector<double>& values) {
  const double mean = Mean(values);
  double sum = 0.0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Where the edge crosses row v, by the first moment of brightness about `u`.
double EdgeInRow(const Picture& picture, double u, int v) {
  const int middle = static_cast<int>(std::lround(u));
  constexpr int kReach = 7;
  const double black = picture.at(middle - kReach, v);
  const double white = picture.at(middle + kReach, v);
  double share = 0.0;  // Of black pixels between.
  for (int i = -kReach; i <= kReach; ++i) {
    share += (white - picture.at(middle + i, v)) / (white - black);
  }
  return middle - kReach - 0.5 + share;
}

TEST(SimBoard, EdgesLieWhereTheyAreToAHundredthOfAPixel) {
  for (const double tilt : {0.0, 0.5, 0.9}) {
    for (const double roll : {0.0, 0.03, 0.2}) {
      for (const double distance : {0.35, 0.61, 1.1}) {
        SimBoard board = HalfBlack();
        // Before the camera, its z away from it, tilted about the edge so that light stays even.
        board.T_world_board = Eigen::Translation3d(0.0137, 0.002, distance) *
                              Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()) *
                              Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX());
        const Picture picture = Take(board, Pose::Identity());
        std::vector<double> errors;
        for (int v = 220; v < 260; ++v) {
          // The edge is a straight line in the image: between the projections of two of its points.
          const auto pixel = [&](double y) {
            return picture.view.camera.Project(board.T_world_board * Eigen::Vector3d(0.0, y, 0.0));
          };
          const Eigen::Vector2d a = pixel(-0.05);
          const Eigen::Vector2d b = pixel(0.05);
          const double truth = a.x() + (v - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
          errors.push_back(EdgeInRow(picture, truth, v) - truth);
        }
        EXPECT_LT(std::abs(Mean(errors)), 0.01) << tilt << " " << roll << " " << distance;
        EXPECT_LT(Deviation(errors), 0.02) << tilt << " " << roll << " " << distance;
      }
    }
  }
}

TEST(SimBoard, IsAFlatSurfaceInDepth) {
  SimBoard board = HalfBlack();
  board.T_world_board =
      Eigen::Translation3d(0.0, 0.0, 0.6) * Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX());
  const Picture picture = Take(board, Pose::Identity());
  const Eigen::Vector3d normal = board.T_world_board.linear().col(2);
  int seen = 0;
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      const size_t i = static_cast<size_t>(v) * 640 + static_cast<size_t>(u);
      if (picture.view.surface[i] != picture.board) {
        EXPECT_TRUE(std::isnan(picture.view.depth.depth[i]));
        continue;
      }
      ++seen;
      const Eigen::Vector3d p =
          picture.view.camera.Unproject(u, v, static_cast<double>(picture.view.depth.depth[i]));
      EXPECT_NEAR(normal.dot(p - board.T_world_board.translation()), 0.0, 1e-5);
    }
  }
  // 0.2 m at 0.6 m, tilted.
  EXPECT_NEAR(seen, std::pow(0.2 / 0.6 * 570.34, 2) * std::cos(0.4), 1500.0);
}

TEST(SimBoard, WhatStandsBeforeItHidesIt) {
  SimScene scene;
  scene.board = HalfBlack();
  scene.board->T_world_board = Eigen::Translation3d(0.0, 0.0, 0.6) * Pose::Identity();
  SimObject plate;
  plate.mesh.vertices = {{-0.02F, -0.02F, 0.0F}, {0.02F, -0.02F, 0.0F}, {0.0F, 0.04F, 0.0F}};
  plate.mesh.triangles = {{0, 1, 2}};
  plate.T_world_object = Eigen::Translation3d(0.0, 0.0, 0.4) * Pose::Identity();
  scene.objects = {plate};
  SceneRenderer renderer(scene, CameraModel{});
  const RenderedView& view = renderer.Render(Pose::Identity());
  std::vector<uint8_t> before;
  ShadeColor(view, &before);
  std::vector<uint8_t> after = before;
  BoardPainter(*scene.board, 1).Paint(view, Pose::Identity(), renderer.Board(), 0, &after);
  int hidden = 0;
  for (size_t i = 0; i < view.surface.size(); ++i) {
    if (view.surface[i] != 0) continue;
    ++hidden;
    EXPECT_EQ(before[3 * i], after[3 * i]);
  }
  EXPECT_GT(hidden, 1000);
}

TEST(SimBoard, NoiseIsOfItsSizeAndAFramesOwn) {
  SimBoard board = HalfBlack();
  board.T_world_board = Eigen::Translation3d(0.0, 0.0, 0.5) * Pose::Identity();
  const Picture clean = Take(board, Pose::Identity());
  board.noise = 2.0;
  const Picture noisy = Take(board, Pose::Identity(), 3);
  std::vector<double> difference;
  for (size_t i = 0; i < clean.view.surface.size(); ++i) {
    if (clean.view.surface[i] != clean.board) continue;
    difference.push_back(static_cast<double>(noisy.rgb[3 * i]) -
                         static_cast<double>(clean.rgb[3 * i]));
  }
  // The clean image is rounded, alike wherever the light is.
  EXPECT_NEAR(Mean(difference), 0.0, 0.3);
  EXPECT_NEAR(Deviation(difference), 2.0, 0.1);
  EXPECT_EQ(noisy.rgb, Take(board, Pose::Identity(), 3).rgb);
  EXPECT_NE(noisy.rgb, Take(board, Pose::Identity(), 4).rgb);
}

TEST(SimBoard, ACameraShowsItInBothResolutions) {
  SimDeviceSetup setup;
  setup.scene.board = HalfBlack();
  setup.scene.board->T_world_board = Eigen::Translation3d(0.0, 0.0, 0.5) * Pose::Identity();
  SimCamera camera(setup);
  camera.Expose(Pose::Identity(), 1, 0.0);
  for (const int width : {640, 320}) {
    const std::vector<uint8_t>& rgb = camera.Color(width);
    const auto at = [&](double u_share) {
      const size_t v = static_cast<size_t>(width) * 3 / 8;
      return rgb[3 * (v * static_cast<size_t>(width) +
                      static_cast<size_t>(u_share * static_cast<double>(width)))];
    };
    EXPECT_LT(at(0.4), 40) << width;
    EXPECT_GT(at(0.6), 200) << width;
    EXPECT_NE(camera.Depth(width)[static_cast<size_t>(width) * static_cast<size_t>(width) * 3 / 8 +
                                  static_cast<size_t>(width) / 2],
              0);
  }
}

}  // namespace
}  // namespace vantage
