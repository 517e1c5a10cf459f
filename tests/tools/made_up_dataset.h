#pragma once

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/depth_rasterizer.h"
#include "common/format.h"
#include "common/so3.h"
#include "perception/model/mesh_primitives.h"
#include "tools/support/png_image.h"

namespace vantage {

/// Small datasets of a box, as vantage-evaluate reads them.
namespace made_up {

namespace fs = std::filesystem;

inline TriangleMesh Box() { return BeveledBox(Eigen::Vector3d(0.06, 0.09, 0.14), 0.003); }

inline CameraModel Camera() { return {160, 120, 142.0, 142.0, 79.5, 59.5}; }

inline Pose BoxPose() {
  Pose T(Eigen::Quaterniond(0.8, 0.3, -0.4, 0.33).normalized());
  T.translation() = Eigen::Vector3d(0.01, -0.02, 0.6);
  return T;
}

inline void WriteText(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

inline void WriteObj(const fs::path& file, const TriangleMesh& mesh) {
  std::string text;
  for (const Eigen::Vector3f& v : mesh.vertices) {
    text += Format("v %.9g %.9g %.9g\n",
                   static_cast<double>(v.x()),
                   static_cast<double>(v.y()),
                   static_cast<double>(v.z()));
  }
  for (const auto& [a, b, c] : mesh.triangles) text += Format("f %u %u %u\n", a + 1, b + 1, c + 1);
  WriteText(file, text);
}

inline DepthImage Draw(const TriangleMesh& mesh, const Pose& T_camera_mesh) {
  const CameraModel camera = Camera();
  DepthRasterizer rasterizer(camera);
  rasterizer.Draw(mesh, T_camera_mesh);
  DepthImage image(camera.width, camera.height);
  for (size_t i = 0; i < image.depth.size(); ++i) {
    if (rasterizer.depth()[i] != DepthRasterizer::kEmpty) image.depth[i] = rasterizer.depth()[i];
  }
  return image;
}

/// Rows of a 3x4 matrix, each number followed by a comma.
inline std::string Numbers(const Pose& T) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 4; ++j) text += Format("%.12g,", T.matrix()(i, j));
  }
  return text;
}

inline std::string TurntableCsv(const Pose& T_markers, const Pose& T_refined) {
  return "view,and,so,on\n0," + Numbers(T_markers) + Numbers(T_refined) + "1,2\n";
}

/// One view of the box, whose markers are 1 deg and 2 mm off.
inline void WriteTurntable(const fs::path& folder, const fs::path& meshes) {
  WriteText(folder / "Intrinsic.txt", "142 0 79.5\n0 142 59.5\n0 0 1\n");
  Pose T_markers = BoxPose() * Eigen::AngleAxisd(kDegree, Eigen::Vector3d::UnitX());
  T_markers.translation().x() += 0.002;
  WriteText(folder / "camera_T_model.csv", TurntableCsv(T_markers, BoxPose()));
  const DepthImage depth = Draw(Box(), BoxPose());
  const Gray16Image image{depth.width, depth.height, DepthToMillimetres(depth)};
  ASSERT_TRUE(WritePng(folder / "depth_00.png", image).ok());
  // The reader takes what is in the file for what its name says: PLY.
  std::string ply = "ply\nformat ascii 1.0\n";
  const TriangleMesh mesh = Box();
  ply += Format("element vertex %zu\nproperty float x\nproperty float y\nproperty float z\n",
                mesh.vertices.size());
  ply += Format("element face %zu\nproperty list uchar int vertex_indices\nend_header\n",
                mesh.triangles.size());
  for (const Eigen::Vector3f& v : mesh.vertices) {
    ply += Format("%.9g %.9g %.9g\n",
                  static_cast<double>(v.x()),
                  static_cast<double>(v.y()),
                  static_cast<double>(v.z()));
  }
  for (const auto& [a, b, c] : mesh.triangles) ply += Format("3 %u %u %u\n", a, b, c);
  WriteText(meshes / "stanford_bunny.ply", ply);
}

/// An 8-bit grey PNG file of rows from top to bottom.
inline std::string GrayPng(int width, int height, const std::vector<uint8_t>& gray) {
  const auto big_endian = [](uint32_t value) {
    std::string bytes;
    for (const unsigned shift : {24U, 16U, 8U, 0U}) bytes += static_cast<char>(value >> shift);
    return bytes;
  };
  std::string rows;
  for (int v = 0; v < height; ++v) {
    rows += '\0';  // No filter.
    rows.append(reinterpret_cast<const char*>(gray.data()) + v * width, static_cast<size_t>(width));
  }
  std::string packed(compressBound(rows.size()), '\0');
  uLongf size = packed.size();
  EXPECT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()),
                     &size,
                     reinterpret_cast<const Bytef*>(rows.data()),
                     rows.size()),
            Z_OK);
  packed.resize(size);
  std::string png = "\x89PNG\r\n\x1a\n";
  const auto chunk = [&](const std::string& type, const std::string& data) {
    const std::string body = type + data;
    png += big_endian(static_cast<uint32_t>(data.size())) + body +
           big_endian(static_cast<uint32_t>(crc32(
               0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()))));
  };
  chunk("IHDR",
        big_endian(static_cast<uint32_t>(width)) + big_endian(static_cast<uint32_t>(height)) +
            std::string("\x08\0\0\0\0", 5));
  chunk("IDAT", packed);
  chunk("IEND", "");
  return png;
}

/// A cloud as a PCD file; compressed ones hold literals alone.
inline std::string Pcd(const std::vector<Eigen::Vector3f>& points,
                       int width,
                       int height,
                       bool is_compressed) {
  std::string body;
  const auto put = [&body](const void* value, size_t size) {
    body.append(static_cast<const char*>(value), size);
  };
  const uint32_t rgba = 0xff112233U;
  if (is_compressed) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      for (const Eigen::Vector3f& p : points) put(&p[axis], 4);
    }
    for (size_t i = 0; i < points.size(); ++i) put(&rgba, 4);
    std::string packed;
    for (size_t at = 0; at < body.size(); at += 32) {
      const std::string run = body.substr(at, 32);
      packed += static_cast<char>(run.size() - 1);
      packed += run;
    }
    const auto raw_size = static_cast<uint32_t>(body.size());
    const auto packed_size = static_cast<uint32_t>(packed.size());
    body.clear();
    put(&packed_size, 4);
    put(&raw_size, 4);
    body += packed;
  } else {
    for (const Eigen::Vector3f& p : points) {
      put(p.data(), 12);
      put(&rgba, 4);
    }
  }
  return Format(
             "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgba\nSIZE 4 4 4 4\nTYPE F F F U\n"
             "COUNT 1 1 1 1\nWIDTH %d\nHEIGHT %d\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS %d\nDATA %s\n",
             width,
             height,
             width * height,
             is_compressed ? "binary_compressed" : "binary") +
         body;
}

}  // namespace made_up
}  // namespace vantage
