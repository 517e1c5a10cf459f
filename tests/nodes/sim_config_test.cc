#include "nodes/sim_config.h"

#include <gtest/gtest.h>

#include <string>

namespace vantage {
namespace {

Result<SimConfig> Load(const std::string& text) {
  Result<ConfigReader> config = ConfigReader::Parse(text, "test.toml");
  EXPECT_TRUE(config.ok());
  return LoadSimConfig(*config);
}

std::string ErrorOf(const std::string& text) {
  const Result<SimConfig> sim = Load(text);
  return sim ? "accepted" : sim.error().message;
}

TEST(SimConfig, ReadsTheDemo) {
  Result<ConfigReader> config = ConfigReader::Open(VANTAGE_SOURCE_DIR "/config/demo.toml");
  ASSERT_TRUE(config.ok());
  const Result<SimConfig> sim = LoadSimConfig(*config);
  ASSERT_TRUE(sim.ok()) << sim.error().message;
  ASSERT_TRUE(sim->scene.table.has_value());
  EXPECT_EQ(sim->arm.table_height, sim->scene.table->height);
  ASSERT_EQ(sim->scene.objects.size(), 3U);
  for (const SimObject& object : sim->scene.objects) {
    EXPECT_FALSE(object.mesh.triangles.empty()) << object.model_id;
    EXPECT_LE(object.mesh.triangles.size(), 20'000U) << object.model_id;
    // It stands on the table.
    EXPECT_NEAR(static_cast<double>(object.mesh.Bounds().min().z()), 0.0, 1e-4) << object.model_id;
  }
  EXPECT_TRUE(sim->sensor.shadow);
  EXPECT_EQ(sim->sensor.device_id, DeviceIdFromSerial(sim->serial));
}

TEST(SimConfig, DefaultsAreThoseOfTheStructs) {
  const Result<SimConfig> sim = Load("[sim]\n");
  ASSERT_TRUE(sim.ok()) << sim.error().message;
  EXPECT_FALSE(sim->scene.table.has_value());
  EXPECT_FALSE(sim->scene.floor.has_value());
  EXPECT_TRUE(sim->scene.objects.empty());
  EXPECT_NEAR(sim->arm.start_azimuth, SimArmParameters{}.start_azimuth, 1e-12);
  EXPECT_NEAR(sim->sensor.dropout_end, SensorModelParameters{}.dropout_end, 1e-12);
  EXPECT_NEAR(sim->sensor.bias_at_1m, SensorModelParameters{}.bias_at_1m, 1e-12);
  EXPECT_NEAR(sim->sensor.baseline, SensorModelParameters{}.baseline, 1e-12);
}

TEST(SimConfig, NoiseSwitchesAllAndPartsOne) {
  const Result<SimConfig> off = Load("[sim.sensor]\nnoise = false\n");
  ASSERT_TRUE(off.ok());
  EXPECT_FALSE(off->sensor.quantization || off->sensor.axial_noise || off->sensor.lateral_noise ||
               off->sensor.shadow || off->sensor.grazing_dropout || off->sensor.bias);
  const Result<SimConfig> one = Load("[sim.sensor]\nnoise = false\nshadow = true\n");
  ASSERT_TRUE(one.ok());
  EXPECT_TRUE(one->sensor.shadow);
  EXPECT_FALSE(one->sensor.bias);
}

TEST(SimConfig, ReadsUnitsAndRanges) {
  const Result<SimConfig> sim = Load(
      "[sim]\nserial = \"A1\"\n[sim.floor]\n[sim.table]\nheight_m = 0.3\n"
      "[sim.arm]\ntarget_m = [0.1, 0.2, 0.35]\nradius_m = [0.5, 0.9]\nstart_elevation_deg = 30\n"
      "[sim.sensor]\nrange_m = [0.5, 3.0]\nbias_at_1m_mm = 2.0\n");
  ASSERT_TRUE(sim.ok()) << sim.error().message;
  EXPECT_EQ(sim->scene.floor->height, -0.75);
  EXPECT_EQ(sim->arm.target, Eigen::Vector3d(0.1, 0.2, 0.35));
  EXPECT_EQ(sim->arm.highest_radius, 0.9);
  EXPECT_NEAR(sim->arm.start_elevation, 30.0 * kDegree, 1e-12);
  EXPECT_EQ(sim->sensor.farthest, 3.0);
  EXPECT_NEAR(sim->sensor.bias_at_1m, 2e-3, 1e-12);
}

TEST(SimConfig, ErrorsNameKeyValueAndBound) {
  EXPECT_NE(ErrorOf("[fusion]\nk = 32\n").find("sim"), std::string::npos);
  EXPECT_NE(ErrorOf("[sim]\nsped = 1\n").find("sim.sped"), std::string::npos);
  EXPECT_NE(ErrorOf("[sim.arm]\nspeed_m_per_s = -1\n").find("speed_m_per_s = -1"),
            std::string::npos);
  EXPECT_NE(ErrorOf("[sim]\ncamera = \"A.*\"\n").find("expected 1 to 64 of"), std::string::npos);
  EXPECT_NE(ErrorOf("[sim.arm]\nradius_m = [0.9, 0.5]\n").find("lower bound first"),
            std::string::npos);
  EXPECT_NE(ErrorOf("[[sim.object]]\nrpy_deg = [0, 0, 0]\n").find("model"), std::string::npos);
  EXPECT_NE(ErrorOf("[[sim.object]]\nmodel = \"../x\"\n").find("expected 1 to 64"),
            std::string::npos);
  EXPECT_NE(ErrorOf("[sim.arm]\nstart_elevation_deg = 5\n")
                .find("start is out of reach: elevation 5.0 deg is below the lowest 20.0 deg"),
            std::string::npos);
  EXPECT_NE(ErrorOf("[sim.sensor]\ndropout_deg = [80.0, 80.0]\n").find("dropout_end"),
            std::string::npos);
}

TEST(SimConfig, ObjectsNeedAModelsFolder) {
  EXPECT_EQ(ErrorOf("[[sim.object]]\nmodel = \"mug\"\n"),
            "test.toml: models.folder: missing; it has no default");
}

TEST(SimConfig, AModelThatIsNotThereIsNamed) {
  const std::string error =
      ErrorOf("[models]\nfolder = \"/nowhere\"\n[[sim.object]]\nmodel = \"teapot\"\n");
  EXPECT_NE(error.find("/nowhere/teapot"), std::string::npos) << error;
}

}  // namespace
}  // namespace vantage
