// Roles of pixels against the counts of the verification itself.

#include "tools/support/stage_pixels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "common/depth_rasterizer.h"
#include "common/so3.h"
#include "perception/model/mesh_primitives.h"

namespace vantage {
namespace {

// A box before a wall, with holes in the depth and a nearer block of another segment.
class StagePixels : public ::testing::Test {
 protected:
  StagePixels() : camera_(CameraModel().Scaled(0.5)), depth_(camera_.width, camera_.height, 1.0F) {
    T_camera_box_.translation() = Eigen::Vector3d(0.01, -0.02, 0.7);
    T_camera_box_.linear() =
        Eigen::AngleAxisd(0.6, Eigen::Vector3d(0.5, 0.7, 0.2).normalized()).toRotationMatrix();
    DepthRasterizer rasterizer(camera_);
    rasterizer.Clear();
    rasterizer.Draw(mesh_.mesh(), T_camera_box_);
    segmentation_.labels.assign(depth_.depth.size(), Segmentation::kNoCluster);
    segmentation_.clusters.resize(2);
    for (size_t i = 0; i < depth_.depth.size(); ++i) {
      if (rasterizer.depth()[i] == DepthRasterizer::kEmpty) continue;
      depth_.depth[i] = rasterizer.depth()[i];
      const int u = static_cast<int>(i) % camera_.width;
      const int v = static_cast<int>(i) / camera_.width;
      if (u % 11 == 0 && v % 5 == 0) depth_.depth[i] = DepthImage::kInvalid;
      const bool is_other = u < 150 && v < 110;
      if (is_other) depth_.depth[i] = 0.5F;
      segmentation_.labels[i] = is_other ? 1 : 0;
      segmentation_.clusters[is_other ? 1 : 0].pixels.push_back(static_cast<uint32_t>(i));
    }
    for (Cluster& cluster : segmentation_.clusters) {
      cluster.window = {0, 0, camera_.width - 1, camera_.height - 1};
    }
    segmentation_.clusters[1].first_label = segmentation_.clusters[1].last_label = 1;
  }

  [[nodiscard]] SegmentedImage Image() const { return {depth_, camera_, segmentation_}; }
  [[nodiscard]] ModelShape Shape() const {
    return {mesh_, Eigen::Vector3d::Zero(), mesh_.radius() * 2.0, mesh_.radius()};
  }

  DrawableMesh mesh_{BeveledBox({0.12, 0.09, 0.06}, 0.004)};
  CameraModel camera_;
  DepthImage depth_;
  Segmentation segmentation_;
  Pose T_camera_box_ = Pose::Identity();
};

std::array<int, 8> Count(const std::vector<PixelRole>& roles) {
  std::array<int, 8> counts{};
  for (const PixelRole role : roles) ++counts[static_cast<size_t>(role)];
  return counts;
}

TEST_F(StagePixels, AddUpToTheVerification) {
  const VerificationParameters parameters;
  ModelView view;
  std::array<int, 8> largest{};
  for (int step = 0; step < 6; ++step) {
    Pose T = T_camera_box_;
    T.translation() += 0.012 * step * Eigen::Vector3d(0.5, 0.4, step % 2 == 0 ? 0.9 : -0.9);
    T.linear() = T.linear() * Eigen::AngleAxisd(0.1 * step, Eigen::Vector3d::UnitX());
    const Verification expected = Verify(Shape(), T, Image(), 0, 1, parameters, &view);
    const auto counts = Count(FindPixelRoles(Shape(), T, Image(), 0, parameters));
    const auto expect = [&](PixelRole role, int count) {
      // Rounding decides a few pixels at the tolerance.
      EXPECT_NEAR(counts[static_cast<size_t>(role)], count, 3) << static_cast<int>(role);
      int& most = largest[static_cast<size_t>(role)];
      most = std::max(most, count);
    };
    expect(PixelRole::kInlier, expected.inliers);
    expect(PixelRole::kOccluded, expected.occluded);
    expect(PixelRole::kSeenThrough, expected.seen_through);
    expect(PixelRole::kInFront, expected.in_front);
    expect(PixelRole::kMissing, expected.missing);
    expect(PixelRole::kEdge, expected.edge);
    expect(PixelRole::kUnexplained, expected.unexplained);
  }
  for (size_t role = 1; role < largest.size(); ++role) {
    EXPECT_GT(largest[role], 5) << "role " << role << " was never put to the test";
  }
}

TEST_F(StagePixels, OutOfViewLeavesTheClusterUnexplained) {
  Pose T = T_camera_box_;
  T.translation().z() = -1.0;
  const auto counts = Count(FindPixelRoles(Shape(), T, Image(), 0, VerificationParameters()));
  EXPECT_EQ(counts[static_cast<size_t>(PixelRole::kUnexplained)],
            static_cast<int>(segmentation_.clusters[0].pixels.size()));
  EXPECT_EQ(counts[static_cast<size_t>(PixelRole::kInlier)], 0);
}

}  // namespace
}  // namespace vantage
