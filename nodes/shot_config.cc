#include "nodes/shot_config.h"

#include "nodes/process.h"

namespace vantage {
namespace {

void ReadMatching(ConfigReader::Table& table, ShotParameters* parameters) {
  table.Read("spacing", &parameters->spacing, 0.005, 0.2);
  table.Read("keypoint_spacing", &parameters->keypoint_spacing, 0.005, 0.5);
  table.Read("descriptor_radius", &parameters->descriptor_radius, 0.005, 1.0);
  table.Read("training_views", &parameters->training_views, 1, 2000);
  table.Read("descriptor_size", &parameters->descriptor_size, 1, 352);
  table.Read("k", &parameters->k, 1, 100);
  table.Read("t_r", &parameters->t_r, 0.0, 1.0);
  table.Read("t_d", &parameters->t_d, 0.0, 1.0);
  table.Read("t_alpha_deg", &parameters->t_alpha_deg, 0.0, 180.0);
  table.Read("inlier_distance", &parameters->inlier_distance, 0.001, 1.0);
  table.Read("probability", &parameters->probability, 0.0, 0.999999);
  table.Read("max_iterations", &parameters->max_iterations, 1, 100000000);
  table.Read("max_hypotheses", &parameters->max_hypotheses, 1, 1000);
}

ShotConfig ReadTables(ConfigReader& config) {
  ShotConfig result;
  ConfigReader::Table shot = config.Root().Sub("shot");
  ReadMatching(shot, &result.estimator.shot);
  ReadEstimatorConfig(config, shot, &result, &result.estimator.estimation);
  return result;
}

}  // namespace

Result<ShotConfig> ReadShotConfig(ConfigReader& config) {
  ShotConfig result = ReadTables(config);
  IgnoreTablesOfOthers(config);
  if (Result<void> read = config.Finish(); !read) return read.error();
  if (Result<void> valid = result.estimator.Validate(); !valid) return valid.error();
  return result;
}

ShotEstimatorParameters ReadShotParameters(ConfigReader& config) {
  return ReadTables(config).estimator;
}

}  // namespace vantage
