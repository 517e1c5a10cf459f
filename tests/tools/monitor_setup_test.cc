// What vantage-doctor says of a configuration, its models and its calibration.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "common/format.h"
#include "tests/tools/monitor_messages.h"
#include "tests/tools/run_program.h"
#include "tools/monitor/doctor.h"
#include "tools/monitor/doctor_setup.h"
#include "tools/monitor/expected_setup.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
using Level = DoctorFinding::Level;

const fs::path kModels = fs::path(VANTAGE_SOURCE_DIR) / "models";

class DoctorSetup : public ScratchTest {
 protected:
  fs::path Write(const std::string& name, const std::string& text) {
    fs::create_directories((scratch() / name).parent_path());
    std::ofstream(scratch() / name) << text;
    return scratch() / name;
  }
  fs::path WriteConfig(const std::string& more = "") {
    return Write(
        "set-up.toml",
        "[camera.XTION]\ndevice = \"index:0\"\n[models]\nfolder = \"models\"\n[ppf]\n" + more);
  }
  void CopyModel(const std::string& name) {
    fs::create_directories(scratch() / "models");
    fs::copy(kModels / name, scratch() / "models" / name, fs::copy_options::recursive);
  }
  // Programs that could be started.
  fs::path MakePrograms() {
    for (const char* name : {"vantage-openni2", "vantage-ppf"}) {
      const fs::path program = Write(std::string("bin/") + name, "#!/bin/sh\n");
      fs::permissions(program, fs::perms::owner_all);
    }
    return scratch() / "bin";
  }
};

TEST_F(DoctorSetup, ConfigurationThatEveryProcessAccepts) {
  const DoctorFinding finding = CheckConfig(WriteConfig(), MakePrograms());
  EXPECT_EQ(finding.level, Level::kOk) << finding.what;
  EXPECT_EQ(finding.what, "accepted by openni2, ppf");
  EXPECT_TRUE(finding.mend.empty());
}

TEST_F(DoctorSetup, ConfigurationThatOneRefuses) {
  for (const char* more : {"max_hypotheses = 0\n", "unknown = 1\n", "[nonsense]\n", "[[[\n"}) {
    const fs::path config = WriteConfig(more);
    const DoctorFinding finding = CheckConfig(config, MakePrograms());
    EXPECT_EQ(finding.level, Level::kWrong) << more;
    EXPECT_NE(finding.what.find("set-up.toml"), std::string::npos) << finding.what;
    EXPECT_NE(finding.mend.find(config.string()), std::string::npos) << finding.mend;
  }
}

TEST_F(DoctorSetup, CamerasOfTheConfiguration) {
  const fs::path config = WriteConfig(
      "[camera.WEB]\ndriver = \"v4l2\"\ndevice = \"path:/dev/video7\"\n[sim]\n[camera.BAD]\ndevice "
      "= "
      "\"nonsense\"\n");
  const std::vector<WantedCamera> cameras = ReadWantedCameras(config);
  ASSERT_EQ(cameras.size(), 2U);
  EXPECT_EQ(cameras[0].name, "WEB");
  EXPECT_EQ(cameras[0].driver, "v4l2");
  EXPECT_FALSE(cameras[0].is_simulated);
  EXPECT_EQ(cameras[1].name, "XTION");
  EXPECT_TRUE(cameras[1].is_simulated);
}

TEST_F(DoctorSetup, ModelsThatLoad) {
  CopyModel("mug");
  const DoctorFindings findings = CheckModels(WriteConfig());
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].level, Level::kOk);
  EXPECT_NE(findings[0].what.find("0.122 m across"), std::string::npos) << findings[0].what;
}

TEST_F(DoctorSetup, ModelsThatDoNotLoad) {
  EXPECT_EQ(CheckModels(WriteConfig())[0].level, Level::kWrong);  // No folder.
  CopyModel("mug");
  const fs::path mesh = scratch() / "models/mug/mesh.ply";
  fs::resize_file(mesh, fs::file_size(mesh) / 2);
  const DoctorFindings findings = CheckModels(WriteConfig());
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].level, Level::kWrong);
  EXPECT_EQ(findings[0].subject, "model mug");
  EXPECT_NE(findings[0].mend.find("vantage-model build MESH --unit mm --output '"),
            std::string::npos);
}

TEST_F(DoctorSetup, ContingencyTables) {
  CopyModel("mug");
  const fs::path table = scratch() / "models/mug/confusion-ppf.bin";
  DoctorFindings findings = CheckModels(WriteConfig("[fusion]\n"));
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[1].level, Level::kOk) << findings[1].what;
  fs::resize_file(table, 100);
  findings = CheckModels(WriteConfig("[fusion]\n"));
  EXPECT_EQ(findings[1].level, Level::kWarning) << findings[1].what;
  EXPECT_NE(findings[1].mend.find("vantage-contingency measure '"), std::string::npos);
  fs::remove(table);
  findings = CheckModels(WriteConfig("[fusion]\n"));
  EXPECT_EQ(findings[1].level, Level::kWarning);
  EXPECT_NE(findings[1].what.find("no contingency table"), std::string::npos);
}

TEST_F(DoctorSetup, ModelInTheWrongUnit) {
  ObjectModel model;
  model.id = "mug";
  model.diameter = 122.0;  // Of millimetres that were taken for metres.
  EXPECT_EQ(CheckModelSize(model, "m").mend, "vantage-model build MESH --unit mm --output 'm'");
  model.diameter = 0.000122;
  EXPECT_EQ(CheckModelSize(model, "m").mend, "vantage-model build MESH --unit m --output 'm'");
  EXPECT_EQ(CheckModelSize(model, "m").level, Level::kWarning);
  model.diameter = 0.122;
  EXPECT_EQ(CheckModelSize(model, "m").level, Level::kOk);
}

TEST_F(DoctorSetup, CalibrationsAgeAndFit) {
  constexpr int64_t kDay = 86400 * kSecond;
  HandEyeFile file;
  file.num_views = 12;
  const auto levels = [&file](int64_t now) {
    const DoctorFindings findings = CheckCalibration(file, "c.toml", now);
    EXPECT_EQ(findings.size(), 2U);
    return std::pair{findings[0].level, findings[1].level};
  };
  EXPECT_EQ(levels(kStart), (std::pair{Level::kUnknown, Level::kOk}));
  file.created_utime = kStart;
  EXPECT_EQ(levels(kStart + 10 * kDay), (std::pair{Level::kOk, Level::kOk}));
  EXPECT_EQ(levels(kStart + 400 * kDay), (std::pair{Level::kWarning, Level::kOk}));
  EXPECT_EQ(CheckCalibration(file, "c.toml", kStart + 400 * kDay)[0].mend,
            "vantage-handeye live --config 'c.toml'");
  EXPECT_EQ(levels(kStart - kDay), (std::pair{Level::kWrong, Level::kOk}));
  file.pixel_rms = 3.0;
  EXPECT_EQ(levels(kStart + kDay), (std::pair{Level::kOk, Level::kWarning}));
}

TEST_F(DoctorSetup, CalibrationFile) {
  EXPECT_TRUE(CheckExtrinsics(WriteConfig(), kStart).empty());
  const fs::path config = WriteConfig("[extrinsics]\ncalibration = \"hand-eye.toml\"\n");
  DoctorFindings findings = CheckExtrinsics(config, kStart);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].level, Level::kWrong);  // It is not there.
  EXPECT_NE(findings[0].mend.find("vantage-handeye live"), std::string::npos);
  Write("hand-eye.toml", "damaged");
  EXPECT_EQ(CheckExtrinsics(config, kStart)[0].level, Level::kWrong);
}

TEST_F(DoctorSetup, BadInputIsRefused) {
  EXPECT_FALSE(Diagnose(SystemView::Real(),
                        {.config = scratch() / "absent.toml", .url = "", .programs = ""}));
  EXPECT_FALSE(Diagnose(SystemView::Real(), {.config = scratch(), .url = "", .programs = ""}));
  EXPECT_FALSE(Diagnose(SystemView::Real(), {.config = "", .url = "tcp://x", .programs = ""}));
  EXPECT_FALSE(ReadExpectedSetup(scratch() / "absent.toml"));
}

}  // namespace
}  // namespace vantage
