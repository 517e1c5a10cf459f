#include "nodes/estimator_node.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "bus/conversions.h"
#include "bus/log_bus.h"
#include "common/depth_rasterizer.h"
#include "perception/model/model_builder.h"
#include "perception/model/model_generator.h"
#include "vantage/detections_v2_t.hpp"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kStart = 1'000'000'000;

class EstimatorNodeTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = fs::temp_directory_path() / ("vantage_estimator_node_test_" + std::to_string(::getpid()));
    fs::create_directories(folder / "models");
    const Result<GeneratedObject> object = GenerateObject("bracket");
    model = std::make_unique<ObjectModel>(
        BuildObjectModel("bracket", object->mesh, object->symmetry, "generated", {}).value());
    ASSERT_TRUE(SaveObjectModel(*model, folder / "models" / "bracket").ok());
  }
  static void TearDownTestSuite() {
    model.reset();
    fs::remove_all(folder);
  }

  static std::string Config(const std::string& more = "") {
    return "[camera.CAM]\ndevice = 'index:0'\n[models]\nfolder = '" + (folder / "models").string() +
           "'\n[ppf]\nseed = 3\n" + more;
  }

  void SetUp() override {
    auto writer = EventLogWriter::Create(input);
    ASSERT_TRUE(writer.ok());
    log = std::move(writer).value();
  }

  template <class Message>
  void Write(int64_t utime, const std::string& channel, const Message& message) {
    ASSERT_TRUE(log->Write(utime, channel, Encode(message)).ok());
  }
  void WriteInfo(int64_t utime) {
    Write(utime, "CAMERA_CAM_INFO", CameraToMessage(camera, {"CAM", "", "", false, ""}, utime, 0));
  }
  void WritePose(int64_t utime, double shift = 0.0) {
    Pose T = T_world_camera;
    T.translation().x() += shift;
    Write(utime, "CAMERA_CAM_TO_WORLD", PoseToMessage(T, utime));
  }
  void WriteImage(int64_t utime, int64_t seq, bool with_object = true) {
    DepthRasterizer rasterizer(camera);
    const Pose T_camera_world = T_world_camera.inverse();
    TriangleMesh table;
    table.vertices = {{-.5F, -.5F, 0}, {.5F, -.5F, 0}, {.5F, .5F, 0}, {-.5F, .5F, 0}};
    table.triangles = {{0, 1, 2}, {0, 2, 3}};
    rasterizer.Draw(table, T_camera_world);
    if (with_object) rasterizer.Draw(model->mesh, T_camera_world * T_world_object);
    std::vector<uint16_t> millimetres;
    for (const float z : rasterizer.depth()) {
      millimetres.push_back(z < 60.0F ? static_cast<uint16_t>(std::lround(1e3F * z)) : 0);
    }
    Write(utime,
          "CAMERA_CAM",
          DepthToMessage(
              camera.width, camera.height, millimetres, utime, seq, "", DepthCompression::kZlib));
  }

  // Runs the node over the log; what it publishes is in `sets`.
  void Run(const std::string& text = Config(), const fs::path& output = {}) {
    ASSERT_TRUE(log->Close().ok());
    std::unique_ptr<EventLogWriter> writer;
    if (!output.empty()) writer = std::move(EventLogWriter::Create(output)).value();
    auto opened = LogBus::Create({}, std::move(EventLogReader::Open(input)).value(), writer.get());
    ASSERT_TRUE(opened.ok());
    bus = std::move(opened).value();
    Result<ConfigReader> config = ConfigReader::Parse(text, "test.toml");
    ASSERT_TRUE(config.ok());
    auto node = MakePpfNode(*bus, *config, {"ppf", false});
    ASSERT_TRUE(node.ok()) << node.error().message;
    ASSERT_TRUE(
        bus->Subscribe<detections_v2_t>(
               "DETECTIONS_PPF",
               {},
               [this](const Envelope&, const detections_v2_t& message) { sets.push_back(message); })
            .ok());
    ASSERT_TRUE(bus->Run().ok());
    if (writer) {
      ASSERT_TRUE(writer->Close().ok());
    }
  }

  static Error MakeError(const std::string& text) {
    const fs::path empty = folder / "empty.log";
    {
      auto writer = std::move(EventLogWriter::Create(empty)).value();
      EXPECT_TRUE(writer->Write(0, "X", Encode(PoseToMessage(Pose::Identity(), 0))).ok());
      EXPECT_TRUE(writer->Close().ok());
    }
    auto bus =
        std::move(LogBus::Create({}, std::move(EventLogReader::Open(empty)).value(), nullptr))
            .value();
    Result<ConfigReader> config = ConfigReader::Parse(text, "test.toml");
    EXPECT_TRUE(config.ok());
    const auto node = MakePpfNode(*bus, *config, {"ppf", false});
    EXPECT_FALSE(node.ok());
    return node.ok() ? Error{} : node.error();
  }

  static inline fs::path folder;
  static inline std::unique_ptr<ObjectModel> model;
  const fs::path input = folder / "in.log";
  CameraModel camera = CameraModel().Scaled(0.5);
  Pose T_world_camera = LookAt({0.4, 0.1, 0.45}, {0.0, 0.0, 0.02});
  Pose T_world_object{Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ())};
  std::unique_ptr<EventLogWriter> log;
  std::unique_ptr<LogBus> bus;
  std::vector<detections_v2_t> sets;
};

TEST_F(EstimatorNodeTest, PublishesEveryImageAtRestAlsoWhenEmpty) {
  WriteInfo(kStart);
  int64_t seq = 40;
  for (int64_t t = 0; t <= 2'000'000; t += 50'000) {
    WritePose(kStart + t);
    if (t == 500'000 || t == 600'000) WriteImage(kStart + t, seq++, t == 500'000);
  }
  Run();
  ASSERT_EQ(sets.size(), 2U);
  EXPECT_EQ(sets[0].utime, kStart + 500'000);
  EXPECT_EQ(sets[0].seq, 0);
  EXPECT_EQ(sets[0].image_seq, 40);
  EXPECT_EQ(sets[0].camera, "CAM");
  EXPECT_EQ(sets[0].estimator, "ppf");
  EXPECT_EQ(sets[0].compute_time, 0.0);
  ASSERT_EQ(sets[0].num_detections, 1);
  EXPECT_EQ(sets[0].detections[0].model_id, "bracket");
  const Result<DetectionSet> set = DetectionsFromMessage(sets[0], "DETECTIONS_PPF");
  ASSERT_TRUE(set.ok());
  const Pose T = set->T_world_camera * set->detections[0].T_camera_object;
  EXPECT_LT((T.translation() - T_world_object.translation()).norm(), 0.003);
  EXPECT_LT(
      GeodesicAngle(Eigen::Quaterniond(T.linear()), Eigen::Quaterniond(T_world_object.linear())),
      1.0 * kDegree);
  EXPECT_EQ(sets[1].seq, 1);
  EXPECT_EQ(sets[1].num_detections, 0);
}

TEST_F(EstimatorNodeTest, CountsImagesThatNeverArrived) {
  for (const int64_t seq : {7, 8, 12, 13}) WriteImage(kStart + seq, seq);
  // Arrived, though it is of no use.
  const std::vector<uint16_t> depth(4);
  images_t bad = DepthToMessage(2, 2, depth, kStart + 14, 14, "", DepthCompression::kNone);
  bad.images[0].data.pop_back();
  --bad.images[0].size;
  Write(kStart + 14, "CAMERA_CAM", bad);
  WriteImage(kStart + 16, 16);
  WriteImage(kStart + 17, 0);  // The sender started anew.
  Run();
  EXPECT_EQ(bus->counters().num_lost, 3 + 1);
}

TEST_F(EstimatorNodeTest, LeavesOutImagesTakenInMotionOrBesideThePoses) {
  WriteInfo(kStart);
  for (int64_t t = 0; t <= 2'000'000; t += 50'000) {
    // Moves until 1.0 s.
    WritePose(kStart + t, t < 1'000'000 ? 1e-7 * static_cast<double>(1'000'000 - t) : 0.0);
    if (t == 300'000 || t == 950'000 || t == 1'500'000 || t == 1'950'000) {
      WriteImage(kStart + t, t / 50'000);
    }
  }
  Run();
  // The last has no poses after it; that of 950 ms has motion before it.
  ASSERT_EQ(sets.size(), 1U);
  EXPECT_EQ(sets[0].image_seq, 30);
}

// The clock is set back by 2 s while the camera is at another place: no image gets a pose, and no
// pose an image, of the other pass. Whether a pose or an image tells first makes no difference.
TEST_F(EstimatorNodeTest, NeverMixesTwoPassesOverTheSameTimes) {
  for (const bool image_first : {false, true}) {
    SCOPED_TRACE(image_first);
    if (image_first) SetUp();
    sets.clear();
    WriteInfo(kStart);
    for (int64_t t = 0; t <= 3'000'000; t += 50'000) {
      WritePose(kStart + t);
      if (t == 2'500'000) WriteImage(kStart + t, 1);
      if (t == 2'950'000) WriteImage(kStart + t, 2);  // Waits for poses that never come.
    }
    const int64_t step = 1'200'000;
    if (image_first) WriteImage(kStart + step, 3);
    for (int64_t t = step; t <= 3'500'000; t += 50'000) {
      WritePose(kStart + t, 0.01);
      if (t == 2'500'000) WriteImage(kStart + t, 4);
    }
    Run();
    ASSERT_EQ(sets.size(), 2U);
    EXPECT_EQ(sets[0].image_seq, 1);
    EXPECT_NEAR(sets[0].camera_trans[0], T_world_camera.translation().x(), 1e-9);
    EXPECT_EQ(sets[1].image_seq, 4);
    EXPECT_NEAR(sets[1].camera_trans[0], T_world_camera.translation().x() + 0.01, 1e-9);
  }
}

TEST_F(EstimatorNodeTest, WaitsForTheCalibration) {
  for (int64_t t = 0; t <= 1'000'000; t += 50'000) {
    WritePose(kStart + t);
    if (t == 300'000) WriteImage(kStart + t, 1);
  }
  WriteInfo(kStart + 1'000'000);
  Run();
  EXPECT_EQ(sets.size(), 1U);
}

TEST_F(EstimatorNodeTest, ResultsDoNotDependOnEarlierImagesAndRunsAreEqual) {
  const auto write = [this](bool with_first) {
    WriteInfo(kStart);
    for (int64_t t = 0; t <= 1'500'000; t += 50'000) {
      WritePose(kStart + t);
      if (t == 400'000 && with_first) WriteImage(kStart + t, 1);
      if (t == 900'000) WriteImage(kStart + t, 2);
    }
  };
  const auto load = [](const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return std::string{std::istreambuf_iterator<char>(stream), {}};
  };
  write(true);
  Run(Config(), folder / "a.log");
  const std::vector<detections_v2_t> first = sets;
  ASSERT_EQ(first.size(), 2U);
  sets.clear();
  SetUp();
  write(true);
  Run(Config(), folder / "b.log");
  EXPECT_EQ(load(folder / "a.log"), load(folder / "b.log"));
  sets.clear();
  SetUp();
  write(false);
  Run();
  ASSERT_EQ(sets.size(), 1U);
  detections_v2_t alone = sets[0];
  alone.seq = first[1].seq;
  EXPECT_EQ(Encode(alone), Encode(first[1]));
}

TEST_F(EstimatorNodeTest, ReportsWhatIsWrongAndGoesOn) {
  camera.width = 100;
  WriteInfo(kStart);
  camera = CameraModel().Scaled(0.5);
  for (int64_t t = 0; t <= 1'000'000; t += 50'000) {
    WritePose(kStart + t);
    if (t == 300'000) WriteImage(kStart + t, 1);
  }
  Run();
  EXPECT_TRUE(sets.empty());
  EXPECT_NE(bus->Status().state.find("expected the 100 x 240 px"), std::string::npos)
      << bus->Status().state;
}

TEST_F(EstimatorNodeTest, RefusesBadConfigInWords) {
  EXPECT_NE(MakeError(Config("[segmentation]\nsupport_plane = 'floor'\n")).message.find("floor"),
            std::string::npos);
  EXPECT_NE(MakeError(Config("[verification]\nmin_scor = 0.1\n")).message.find("min_scor"),
            std::string::npos);
  EXPECT_NE(MakeError(Config("[refinement]\ntukey_sigmas = 0.0\n")).message.find("tukey_sigmas"),
            std::string::npos);
  EXPECT_NE(MakeError("[camera.A]\n[camera.B]\n[models]\nfolder='x'\n").message.find("ppf.camera"),
            std::string::npos);
  EXPECT_NE(MakeError("[camera.A]\n").message.find("models.folder"), std::string::npos);
}

TEST_F(EstimatorNodeTest, NamesModelsThatAreMissingAndThoseThatExist) {
  std::string text = Config();
  text.insert(text.find("[ppf]"), "use = ['spoon']\n");
  const Error absent = MakeError(text);
  EXPECT_EQ(absent.code, ErrorCode::kNotFound);
  for (const char* part : {"spoon", "bracket", "vantage-model generate", "models"}) {
    EXPECT_NE(absent.message.find(part), std::string::npos) << absent.message;
  }
  const Error nowhere = MakeError("[camera.A]\n[models]\nfolder = '/nowhere/at/all'\n");
  EXPECT_NE(nowhere.message.find("/nowhere/at/all"), std::string::npos);
  EXPECT_NE(nowhere.message.find("vantage-model generate"), std::string::npos);
}

TEST_F(EstimatorNodeTest, TakesTheTableInTheModelFolderIfItFits) {
  const fs::path file = folder / "models" / "bracket" / "ppf.bin";
  PpfTableParameters parameters;
  const PpfTable table =
      std::move(PpfTable::Train(model->samples, model->diameter, parameters)).value();
  for (const uint64_t hash : {model->mesh_hash, model->mesh_hash + 1}) {
    ASSERT_TRUE(table.Save(file, hash).ok());
    const auto models = LoadPpfModels({folder / "models", {}}, parameters);
    ASSERT_TRUE(models.ok());
    ASSERT_EQ(models->size(), 1U);
    EXPECT_EQ((*models)[0].table.num_entries(), table.num_entries());
  }
  parameters.angle_step_deg = 20.0;
  const auto models = LoadPpfModels({folder / "models", {}}, parameters);
  ASSERT_TRUE(models.ok());
  EXPECT_EQ((*models)[0].table.parameters(), parameters);
  fs::remove(file);
}

}  // namespace
}  // namespace vantage
