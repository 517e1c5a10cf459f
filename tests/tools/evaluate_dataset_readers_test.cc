#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/tools/made_up_dataset.h"
#include "tests/tools/run_program.h"
#include "tools/evaluate/dataset.h"
#include "tools/evaluate/dataset_scan.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using made_up::BoxPose;
using made_up::WriteText;

class DatasetTest : public ScratchTest {
 protected:
  [[nodiscard]] fs::path folder() const { return scratch() / "set"; }
  [[nodiscard]] fs::path meshes() const { return scratch() / "meshes"; }
  [[nodiscard]] Result<Dataset> Load() const { return LoadDataset(folder(), meshes()); }
  void ExpectRefused(const std::string& part) const {
    const Result<Dataset> dataset = Load();
    ASSERT_FALSE(dataset.ok()) << part;
    EXPECT_NE(dataset.error().message.find(part), std::string::npos) << dataset.error().message;
    EXPECT_EQ(dataset.error().message.find('\n'), std::string::npos) << dataset.error().message;
  }
};

TEST_F(DatasetTest, AFolderIsRecognisedOrTheErrorSaysWhatIsExpected) {
  const auto message = [](const fs::path& path) {
    const Result<std::vector<fs::path>> found = FindDatasets(path);
    return found.ok() ? std::string() : found.error().message;
  };
  EXPECT_NE(message(scratch() / "absent").find("absent is no folder"), std::string::npos);
  fs::create_directories(folder());
  EXPECT_NE(message(folder()).find("camera_T_model.csv"), std::string::npos) << message(folder());
  EXPECT_FALSE(Load().ok());
  WriteText(scratch() / "b" / "milk.pcd", "");
  WriteText(scratch() / "a" / "000001-meta.json", "");
  WriteText(scratch() / "c" / "camera_T_model.csv", "");
  const Result<std::vector<fs::path>> found = FindDatasets(scratch());
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(*found, (std::vector<fs::path>{scratch() / "a", scratch() / "b", scratch() / "c"}));
  EXPECT_EQ(*FindDatasets(scratch() / "b"), std::vector<fs::path>{scratch() / "b"});
}

TEST_F(DatasetTest, AShelfWithoutGroundTruthIsDeclined) {
  WriteText(folder() / "cam.info.txt", "");
  EXPECT_FALSE(WhyNotEvaluated(folder()).has_value());
  WriteText(folder() / "final_pose.txt", "");
  ASSERT_TRUE(WhyNotEvaluated(folder()).has_value());
  ExpectRefused("no exact ground truth");
}

TEST_F(DatasetTest, ATurntableIsRead) {
  made_up::WriteTurntable(folder(), meshes());
  const Result<Dataset> dataset = Load();
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  EXPECT_EQ(dataset->name, "set");
  ASSERT_EQ(dataset->models.size(), 1U);
  EXPECT_NEAR(dataset->models[0].diameter, Eigen::Vector3d(0.06, 0.09, 0.14).norm(), 0.01);
  ASSERT_EQ(dataset->views.size(), 1U);
  const DatasetView& view = dataset->views[0];
  EXPECT_TRUE(view.is_segmented);
  EXPECT_EQ(view.camera, made_up::Camera());
  ASSERT_EQ(view.objects.size(), 1U);
  EXPECT_TRUE(view.objects[0].T_camera_object.isApprox(BoxPose(), 1e-9));
  ASSERT_TRUE(view.objects[0].T_camera_object_other.has_value());
  const Pose between = BoxPose().inverse() * *view.objects[0].T_camera_object_other;
  EXPECT_NEAR(Eigen::AngleAxisd(between.linear()).angle(), kDegree, 1e-8);
  EXPECT_NEAR(between.translation().norm(), 0.002, 1e-9);
  const DepthImage drawn = made_up::Draw(made_up::Box(), BoxPose());
  for (size_t i = 0; i < drawn.depth.size(); ++i) {
    ASSERT_EQ(std::isnan(drawn.depth[i]), std::isnan(view.depth.depth[i]));
    if (!std::isnan(drawn.depth[i])) {
      ASSERT_NEAR(drawn.depth[i], view.depth.depth[i], 0.00051);
    }
  }
}

TEST_F(DatasetTest, ADamagedTurntableIsOneSentence) {
  made_up::WriteTurntable(folder(), meshes());
  const fs::path csv = folder() / "camera_T_model.csv";
  WriteText(csv, "view\n");
  ExpectRefused("0 views");
  WriteText(csv, "view\n0,1,2,3\n");
  ExpectRefused("line 2: column 5 of 25");
  Pose T_bad = BoxPose();
  T_bad.translation().x() = std::numeric_limits<double>::quiet_NaN();
  WriteText(csv, made_up::TurntableCsv(BoxPose(), T_bad));
  ExpectRefused("line 2: column 17 of 25");
  T_bad = BoxPose();
  T_bad.linear() *= 2.0;
  WriteText(csv, made_up::TurntableCsv(T_bad, BoxPose()));
  ExpectRefused("camera_T_model.csv line 2");
  WriteText(csv, "view\n-1," + made_up::Numbers(BoxPose()) + made_up::Numbers(BoxPose()));
  ExpectRefused("view -1");

  WriteText(csv, made_up::TurntableCsv(BoxPose(), BoxPose()));
  ASSERT_TRUE(Load().ok());
  const fs::path png = folder() / "depth_00.png";
  fs::resize_file(png, fs::file_size(png) / 2);
  ExpectRefused("depth_00.png is no sound PNG");
  ASSERT_TRUE(WritePng(png, RgbImage{2, 2, std::vector<uint8_t>(12)}).ok());
  ExpectRefused("expected a 16-bit grey PNG");
  fs::remove(png);
  ExpectRefused("depth_00.png");
  made_up::WriteTurntable(folder(), meshes());
  WriteText(folder() / "Intrinsic.txt", "142 0\n");
  ExpectRefused("Intrinsic.txt");
  made_up::WriteTurntable(folder(), meshes());
  WriteText(meshes() / "stanford_bunny.ply", "ply\n");
  ExpectRefused("stanford_bunny.ply");
  fs::remove(meshes() / "stanford_bunny.ply");
  ExpectRefused("stanford_bunny.ply");
}

/// One frame with a box for a foam brick and an object that has no mesh.
class YcbvTest : public DatasetTest {
 protected:
  void SetUp() override {
    DatasetTest::SetUp();
    made_up::WriteObj(meshes() / "ycb_FoamBrick.obj", made_up::Box());
    // The scan's frame as the reader knows it, and a little off.
    Pose T_mesh_points(ExpSo3(kDegree * Eigen::Vector3d(1.5, 2.3, -18.9)));
    T_mesh_points.translation() = Eigen::Vector3d(-0.010, -0.002, 0.0);
    T_mesh_points_ = T_mesh_points * Eigen::AngleAxisd(0.5 * kDegree, Eigen::Vector3d::UnitY()) *
                     Eigen::Translation3d(0.0005, -0.0004, 0.0003);
    Rng rng(3);
    std::string points;
    for (const SurfacePoint& sample : SampleSurface(made_up::Box(), 500, rng)) {
      const Eigen::Vector3d p = T_mesh_points_.inverse() * sample.position.cast<double>();
      points += Format("%.8f %.8f %.8f\n", p.x(), p.y(), p.z());
    }
    WriteText(PointsFile(), points);
    WriteMeta(Meta());
    WriteImages(made_up::Camera().width);
  }
  [[nodiscard]] fs::path PointsFile() const {
    return folder() / "models" / "061_foam_brick" / "points.xyz";
  }
  [[nodiscard]] Json Meta() const {
    const Pose T = BoxPose() * T_mesh_points_;
    Json pose = Json::array();
    for (int i = 0; i < 3; ++i) {
      pose.push_back({T.matrix()(i, 0), T.matrix()(i, 1), T.matrix()(i, 2), T.matrix()(i, 3)});
    }
    Json mug = {{"cls_index", 14}, {"name", "025_mug"}, {"camera_T_model_3x4", pose}};
    Json brick = {{"cls_index", 21}, {"name", "061_foam_brick"}, {"camera_T_model_3x4", pose}};
    return {{"intrinsic_matrix", {{142.0, 0.0, 79.5}, {0.0, 142.0, 59.5}, {0.0, 0.0, 1.0}}},
            {"factor_depth", 10000},
            {"objects", {mug, brick}}};
  }
  void WriteMeta(const Json& json) const { WriteText(folder() / "000001-meta.json", json.dump()); }
  // A label image of another width is allowed here.
  void WriteImages(int label_width) const {
    const DepthImage depth = made_up::Draw(made_up::Box(), BoxPose());
    Gray16Image image{depth.width, depth.height, std::vector<uint16_t>(depth.depth.size(), 0)};
    for (size_t i = 0; i < depth.depth.size(); ++i) {
      if (depth.depth[i] > 0.0F) {
        image.gray[i] = static_cast<uint16_t>(std::lround(1e4F * depth.depth[i]));
      }
    }
    ASSERT_TRUE(WritePng(folder() / "000001-depth.png", image).ok());
    std::vector<uint8_t> labels;
    for (int v = 0; v < depth.height; ++v) {
      for (int u = 0; u < label_width; ++u) {
        labels.push_back(depth.Contains(u, v) && depth.at(u, v) > 0.0F ? 21 : 0);
      }
    }
    WriteText(folder() / "000001-label.png", made_up::GrayPng(label_width, depth.height, labels));
  }

  Pose T_mesh_points_ = Pose::Identity();
};

TEST_F(YcbvTest, AFrameIsRead) {
  const Result<Dataset> dataset = Load();
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  ASSERT_EQ(dataset->models.size(), 1U);
  EXPECT_EQ(dataset->models[0].id, "061_foam_brick");
  EXPECT_EQ(dataset->models[0].symmetry.elements.size(), 4U);
  ASSERT_EQ(dataset->views.size(), 1U);
  const DatasetView& view = dataset->views[0];
  EXPECT_EQ(view.name, "000001");
  EXPECT_EQ(view.camera, made_up::Camera());
  EXPECT_FALSE(view.is_segmented);
  // The pose of the mesh, not of the points; the mug has no mesh.
  ASSERT_EQ(view.objects.size(), 1U);
  const Pose between = BoxPose().inverse() * view.objects[0].T_camera_object;
  EXPECT_LT(Eigen::AngleAxisd(between.linear()).angle(), 0.02 * kDegree);
  EXPECT_LT(between.translation().norm(), 2e-5);
  const auto measured = std::count_if(
      view.depth.depth.begin(), view.depth.depth.end(), [](float depth) { return depth > 0.0F; });
  EXPECT_EQ(static_cast<long>(view.objects[0].pixels.size()), measured);
  EXPECT_TRUE(
      std::any_of(dataset->notes.begin(), dataset->notes.end(), [](const std::string& note) {
        return note.find("025_mug in 000001") != std::string::npos;
      }));
}

TEST_F(YcbvTest, ADamagedFrameIsOneSentence) {
  const auto with = [this](const char* key, const Json& value) {
    Json json = Meta();
    json[key] = value;
    WriteMeta(json);
  };
  WriteText(folder() / "000001-meta.json", "{");
  ExpectRefused("is no JSON");
  WriteText(folder() / "000001-meta.json", "[]");
  ExpectRefused("intrinsic_matrix");
  with("intrinsic_matrix", {{1.0, 2.0}});
  ExpectRefused("intrinsic_matrix is absent or not 3 x 3");
  with("factor_depth", 0);
  ExpectRefused("factor_depth");
  with("factor_depth", "10000");
  ExpectRefused("factor_depth");
  with("objects", Json::array());
  ExpectRefused("objects");
  Json json = Meta();
  json["objects"][1]["camera_T_model_3x4"][1][2] = nullptr;
  WriteMeta(json);
  ExpectRefused("camera_T_model_3x4");
  json = Meta();
  json["objects"][1]["cls_index"] = 256;
  WriteMeta(json);
  ExpectRefused("cls_index");

  WriteMeta(Meta());
  WriteImages(80);
  ExpectRefused("80 x 120 px, expected 160 x 120");
  fs::remove(folder() / "000001-label.png");
  ExpectRefused("000001-label.png");
  WriteImages(160);
  fs::resize_file(folder() / "000001-depth.png", 60);
  ExpectRefused("000001-depth.png");
  WriteImages(160);
  ASSERT_TRUE(Load().ok());
  WriteText(PointsFile(), "1 2 3\n");
  ExpectRefused("1 points");
  fs::remove(PointsFile());
  ExpectRefused("points.xyz");
  // Points of something else.
  std::string ball;
  Rng rng(5);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d p = 0.2 * rng.UnitVector();
    ball += Format("%.6f %.6f %.6f\n", p.x(), p.y(), p.z());
  }
  WriteText(PointsFile(), ball);
  ExpectRefused("off");
  fs::remove(meshes() / "ycb_FoamBrick.obj");
  ExpectRefused("has no mesh of any object");
}

/// The box before a wall and a cloud that was cut from it.
class SceneCropTest : public DatasetTest {
 protected:
  // As the reader knows it.
  static Pose CameraFromModel() {
    Eigen::Matrix3d R;
    R << 0.968879414, -0.119712210, 0.216660259, 0.116826833, 0.992808636, 0.026124781,
        -0.218229631, -3.0e-8, 0.975897447;
    Pose T = Pose::Identity();
    T.linear() = Eigen::Quaterniond(R).normalized().toRotationMatrix();
    T.translation() = Eigen::Vector3d(-0.15896556, 0.21249808, -0.04212537);
    Pose flip = Pose::Identity();
    flip.linear().diagonal() << 1.0, -1.0, -1.0;
    return flip * T;
  }
  void Write(double focal, double model_shift) const {
    CameraModel camera{640, 480, focal, focal, 319.5, 239.5};
    DepthRasterizer rasterizer(camera);
    rasterizer.Draw(made_up::Box(), BoxPose());
    std::vector<Eigen::Vector3f> scene;
    std::vector<Eigen::Vector3f> model;
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const float drawn = rasterizer.depth()[static_cast<size_t>(v * camera.width + u)];
        const bool is_box = drawn != DepthRasterizer::kEmpty;
        Eigen::Vector3d p = camera.Unproject(u, v, is_box ? static_cast<double>(drawn) : 1.0);
        if (is_box) {
          p.x() += model_shift;
          model.push_back((CameraFromModel().inverse() * p).cast<float>());
          p.x() -= model_shift;
        }
        scene.emplace_back(p.cast<float>().cwiseProduct(Eigen::Vector3f(1.0F, -1.0F, -1.0F)));
      }
    }
    scene[0].setConstant(std::numeric_limits<float>::quiet_NaN());
    WriteText(folder() / "scene.pcd", made_up::Pcd(scene, 640, 480, true));
    WriteText(folder() / "milk.pcd", made_up::Pcd(model, static_cast<int>(model.size()), 1, false));
  }
};

TEST_F(SceneCropTest, ACropIsRead) {
  Write(525.0, 0.0);
  const Result<Dataset> dataset = Load();
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  ASSERT_EQ(dataset->views.size(), 1U);
  const DatasetView& view = dataset->views[0];
  ASSERT_EQ(view.objects.size(), 1U);
  EXPECT_TRUE(std::isnan(view.depth.at(0, 0)));
  EXPECT_FLOAT_EQ(view.depth.at(639, 0), 1.0F);
  // Drawn in its pose the model shows what was measured, nearly wherever it is.
  DepthRasterizer rasterizer(view.camera);
  rasterizer.Draw(dataset->models[0].mesh, view.objects[0].T_camera_object);
  size_t same = 0;
  for (const uint32_t pixel : view.objects[0].pixels) {
    same += std::abs(rasterizer.depth()[pixel] - view.depth.depth[pixel]) < 1e-4F ? 1 : 0;
  }
  EXPECT_GT(same, 0.9 * static_cast<double>(view.objects[0].pixels.size()));
  // Its normals face the camera.
  const TriangleMesh& mesh = dataset->models[0].mesh;
  const Eigen::Matrix3f R = view.objects[0].T_camera_object.linear().cast<float>();
  EXPECT_LT((R * mesh.ScaledNormal(mesh.triangles.size() / 2)).z(), 0.0F);
}

TEST_F(SceneCropTest, ADamagedCropIsOneSentence) {
  Write(525.0, 0.001);
  ExpectRefused("not one of the scene's");
  Write(500.0, 0.0);
  ExpectRefused("lines of sight");
  Write(525.0, 0.0);
  fs::resize_file(folder() / "scene.pcd", fs::file_size(folder() / "scene.pcd") - 5);
  ExpectRefused("scene.pcd is no sound PCD file");
  fs::remove(folder() / "scene.pcd");
  ExpectRefused("0 point clouds beside milk.pcd");
}

}  // namespace
}  // namespace vantage
