#include "nodes/ppf_config.h"

#include "nodes/process.h"

namespace vantage {
namespace {

void ReadVoting(ConfigReader::Table& ppf, PpfEstimatorParameters* parameters) {
  PpfTableParameters& table = parameters->table;
  ppf.Read("sample_distance", &table.sample_distance, 0.01, 0.5);
  ppf.Read("distance_step", &table.distance_step, 0.01, 0.5);
  ppf.Read("angle_step_deg", &table.angle_step_deg, 4.0, 60.0);
  PpfVotingParameters& voting = parameters->voting;
  ppf.Read("reference_share", &voting.reference_share, 0.001, 1.0);
  ppf.Read("min_references", &voting.min_references, 1, 10000);
  ppf.Read("max_references", &voting.max_references, 1, 10000);
  ppf.Read("turn_bins", &voting.turn_bins, 4, 360);
  ppf.Read("spread", &voting.spread, 0.0, 0.5);
  ppf.Read("votes_per_reference", &voting.votes_per_reference, 1, 30000);
  ppf.Read("peaks_per_reference", &voting.peaks_per_reference, 1, 100);
  ppf.Read("max_hypotheses", &voting.max_hypotheses, 1, 1000);
}

PpfConfig ReadTables(ConfigReader& config) {
  PpfConfig result;
  ConfigReader::Table ppf = config.Root().Sub("ppf");
  ReadVoting(ppf, &result.estimator);
  ReadEstimatorConfig(config, ppf, &result, &result.estimator.estimation);
  return result;
}

}  // namespace

Result<PpfConfig> ReadPpfConfig(ConfigReader& config) {
  PpfConfig result = ReadTables(config);
  IgnoreTablesOfOthers(config);
  if (Result<void> read = config.Finish(); !read) return read.error();
  if (Result<void> valid = result.estimator.Validate(); !valid) return valid.error();
  return result;
}

PpfEstimatorParameters ReadPpfParameters(ConfigReader& config) {
  return ReadTables(config).estimator;
}

}  // namespace vantage
