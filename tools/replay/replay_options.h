#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "nodes/config_reader.h"
#include "tools/replay/estimator_cache.h"

namespace vantage {

/// What is rerun, on what, and where the result goes.
struct ReplayOptions {
  std::string log;     ///< LCM event log
  std::string output;  ///< log for what is recomputed; empty: none
  std::vector<std::string> estimators = {"ppf"};
  bool with_inputs = false;      ///< copy what is read into the output too
  bool with_extrinsics = false;  ///< camera poses anew too, from HAND_TO_BASE
  bool as_received = false;      ///< estimators get the images that they worked on live, alone
  std::string channels;          ///< regular expression: what of the log is read; empty: all
  std::string from;              ///< a place in the log (log_place.h); empty: its start
  std::string to;                ///< empty: its end
  int threads = 1;               ///< 1 or more; the result is the same for any number
  /// The configuration, from its start: every node takes its own tables of it. Called on the
  /// thread that runs the rerun alone.
  std::function<Result<ConfigReader>()> open_config;
  /// Given to several reruns they load models and train tables once; null: one of its own.
  std::shared_ptr<EstimatorCache> cache;
};

}  // namespace vantage
