#include "tools/replay/replay_arguments.h"

namespace vantage {

void AddReplayArguments(CLI::App* app, ReplayOptions* options) {
  app->add_option("log", options->log, "LCM event log")->required();
  app->add_option("--output,-o", options->output, "log to write what is recomputed to");
  app->add_option("--estimator", options->estimators, "ppf, shot, or both; default: ppf")
      ->check(CLI::IsMember({"ppf", "shot"}));
  app->add_flag("--with-inputs", options->with_inputs, "copy what is read into the output too");
  app->add_flag("--extrinsics",
                options->with_extrinsics,
                "camera poses anew too, from HAND_TO_BASE by the calibration of [extrinsics]");
}

}  // namespace vantage
