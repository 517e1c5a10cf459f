#include "tools/monitor/doctor_setup.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <system_error>

#include "common/format.h"
#include "common/so3.h"
#include "nodes/camera_config.h"
#include "nodes/config_reader.h"
#include "nodes/extrinsics_config.h"
#include "nodes/fusion_config.h"
#include "nodes/models_config.h"
#include "tools/monitor/shown_text.h"
#include "tools/supervise/process_plan.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;
using Level = DoctorFinding::Level;

constexpr double kSmallest = 0.01;              // m, of an object
constexpr double kLargest = 2.0;                // m
constexpr double kOld = 180.0;                  // days, of a calibration
constexpr double kTranslationRms = 0.005;       // m
constexpr double kRotationRms = 0.5 * kDegree;  // rad
constexpr double kPixelRms = 1.0;               // px

std::string Quoted(const fs::path& path) { return Format("'%s'", path.c_str()); }

// Contingency tables that fusion would not use, and models without one.
void CheckTables(const fs::path& config, const ModelsConfig& models, DoctorFindings* findings) {
  Result<ConfigReader> reader = ConfigReader::Open(config);
  if (!reader || !reader->Root().Has("fusion")) return;
  const Result<FusionConfig> fusion = ReadFusionConfig(*reader);
  if (!fusion) {
    findings->push_back({Level::kWrong, "models", fusion.error().message, ""});
    return;
  }
  for (const auto& [id, model] : fusion->models) {
    const std::string measure =
        "vantage-contingency measure " + Quoted(models.folder / id) + " --config " + Quoted(config);
    const auto refused = fusion->refused_tables.find(id);
    if (refused != fusion->refused_tables.end()) {
      findings->push_back({Level::kWarning, "table of " + id, refused->second, measure});
    } else if (model.confusion == nullptr) {
      findings->push_back({Level::kWarning,
                           "table of " + id,
                           "there is no contingency table: its detections are weighed by "
                           "confidence alone",
                           measure});
    } else {
      findings->push_back({Level::kOk, "table of " + id, "a contingency table of this set-up", ""});
    }
  }
}

std::string SymmetryText(const SymmetryGroup& symmetry) {
  if (symmetry.kind == SymmetryGroup::Kind::kContinuous) return "symmetric about an axis";
  if (symmetry.elements.size() > 1) return Format("%zu-fold symmetric", symmetry.elements.size());
  return "no symmetry known";
}

}  // namespace

DoctorFinding CheckConfig(const fs::path& config, const fs::path& programs) {
  const Result<ProcessPlan> plan = MakeProcessPlan(config, programs);
  if (!plan) {
    return {
        Level::kWrong, "configuration", plan.error().message, "${EDITOR:-vi} " + Quoted(config)};
  }
  std::string names;
  for (const PlannedProcess& process : plan->processes) {
    names += (names.empty() ? "" : ", ") + process.name;
  }
  return {Level::kOk, "configuration", "accepted by " + names, ""};
}

std::vector<WantedCamera> ReadWantedCameras(const fs::path& config) {
  std::vector<WantedCamera> wanted;
  Result<ConfigReader> names = ConfigReader::Open(config);
  if (!names) return wanted;
  ConfigReader::Table root = names->Root();
  std::string simulated = "XTION";
  if (root.Has("sim")) root.Sub("sim").Read("camera", &simulated);
  for (const std::string& name : root.Sub("camera").Keys()) {
    std::string driver = "openni2";
    root.Sub("camera").Sub(name).Read("driver", &driver);
    std::string device;
    root.Sub("camera").Sub(name).Read("device", &device);
    if (!DeviceSelector::Parse(device)) continue;
    std::string process = driver + "-";
    for (const char c : name) {
      process += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    Result<ConfigReader> reader = ConfigReader::Open(config);
    if (!reader) return wanted;
    const Result<CameraConfig> camera = ReadCameraConfig(*reader, process, driver);
    if (!camera) continue;
    const bool is_simulated = driver == "openni2" && root.Has("sim") && name == simulated &&
                              camera->device.kind != DeviceSelector::Kind::kRecording;
    wanted.push_back({name, driver, camera->device, is_simulated});
  }
  return wanted;
}

DoctorFinding CheckModelSize(const ObjectModel& model, const fs::path& folder) {
  const std::string subject = "model " + model.id;
  std::error_code error;
  const std::string what =
      Format("%zu triangles, %.3g m across, %s, matching table %s",
             model.mesh.triangles.size(),
             model.diameter,
             SymmetryText(model.symmetry).c_str(),
             fs::exists(folder / "ppf.bin", error) ? "there" : "made at each start");
  if (model.diameter >= kSmallest && model.diameter <= kLargest) {
    return {Level::kOk, subject, what, ""};
  }
  const char* unit = model.diameter > kLargest ? "mm" : "m";
  return {
      Level::kWarning,
      subject,
      what + Format(": the mesh's unit was perhaps not what it was built with, expected %s", unit),
      Format("vantage-model build MESH --unit %s --output %s", unit, Quoted(folder).c_str())};
}

DoctorFindings CheckModels(const fs::path& config) {
  Result<ConfigReader> reader = ConfigReader::Open(config);
  if (!reader || !reader->Root().Has("models")) return {};
  const ModelsConfig models = ReadModelsConfig(*reader);
  const Result<std::vector<std::string>> names = FindModels(models);
  if (!names)
    return {{Level::kWrong, "models", names.error().message, "vantage-model generate --help"}};
  DoctorFindings findings;
  bool all_load = true;
  for (const std::string& name : *names) {
    const fs::path folder = models.folder / name;
    const Result<ObjectModel> model = LoadObjectModel(folder);
    if (!model) {
      all_load = false;
      findings.push_back({Level::kWrong,
                          "model " + name,
                          model.error().message,
                          "vantage-model build MESH --unit mm --output " + Quoted(folder)});
      continue;
    }
    findings.push_back(CheckModelSize(*model, folder));
  }
  if (all_load) CheckTables(config, models, &findings);
  return findings;
}

DoctorFindings CheckExtrinsics(const fs::path& config, int64_t now) {
  Result<ConfigReader> reader = ConfigReader::Open(config);
  if (!reader || !reader->Root().Has("extrinsics")) return {};
  const Result<ExtrinsicsConfig> extrinsics = ReadExtrinsicsConfig(*reader);
  const std::string measure = "vantage-handeye live --config " + Quoted(config);
  if (!extrinsics) return {{Level::kWrong, "calibration", extrinsics.error().message, ""}};
  const Result<HandEyeFile> file = ReadHandEyeFile(extrinsics->calibration);
  if (!file) return {{Level::kWrong, "calibration", file.error().message, measure}};
  DoctorFindings findings = CheckCalibration(*file, config, now);
  if (file->camera != extrinsics->camera) {
    findings.push_back({Level::kWrong,
                        "calibration",
                        Format("it is of camera %s, expected %s",
                               Shown(file->camera).c_str(),
                               Shown(extrinsics->camera).c_str()),
                        measure});
  }
  return findings;
}

DoctorFindings CheckCalibration(const HandEyeFile& calibration,
                                const fs::path& config,
                                int64_t now) {
  const std::string measure = "vantage-handeye live --config " + Quoted(config);
  DoctorFindings findings;
  const double days = 1e-6 * static_cast<double>(now - calibration.created_utime) / 86400.0;
  if (calibration.created_utime == 0) {
    findings.push_back({Level::kUnknown, "calibration's age", "the file does not tell it", ""});
  } else if (days < 0.0) {
    findings.push_back({Level::kWrong,
                        "calibration's age",
                        Format("it was made %.0f days from now: a clock is wrong", -days),
                        "date"});
  } else {
    findings.push_back({days <= kOld ? Level::kOk : Level::kWarning,
                        "calibration's age",
                        Format("%.0f days", days),
                        days <= kOld ? "" : measure});
  }
  const bool fits = calibration.translation_rms <= kTranslationRms &&
                    calibration.rotation_rms <= kRotationRms && calibration.pixel_rms <= kPixelRms;
  findings.push_back({fits ? Level::kOk : Level::kWarning,
                      "calibration's fit",
                      Format("%d views, %d left out, residuals of %.2f deg, %.2f mm, %.2f px%s",
                             calibration.num_views,
                             calibration.num_outliers,
                             calibration.rotation_rms / kDegree,
                             1e3 * calibration.translation_rms,
                             calibration.pixel_rms,
                             fits ? "" : ", expected at most 0.5 deg, 5 mm, 1 px"),
                      fits ? "" : measure});
  return findings;
}

}  // namespace vantage
