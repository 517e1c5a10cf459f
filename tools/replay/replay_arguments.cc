#include "tools/replay/replay_arguments.h"

#include <algorithm>
#include <thread>

namespace vantage {

void AddReplayArguments(CLI::App* app, ReplayOptions* options) {
  app->add_option("log", options->log, "LCM event log")->required();
  app->add_option("--output,-o", options->output, "log to write what is recomputed to");
  app->add_option("--estimator", options->estimators, "ppf, shot, or both; default: ppf")
      ->check(CLI::IsMember({"ppf", "shot"}));
  app->add_flag("--with-inputs", options->with_inputs, "copy what is read into the output too");
  app->add_flag("--as-received",
                options->as_received,
                "estimators get the images that they worked on live, and no others");
  options->threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  app->add_option("--threads",
                  options->threads,
                  "how many; the output is the same for any number; default: one a core");
  app->add_option("--channels", options->channels, "regular expression: read these channels alone");
  app->add_option("--from", options->from, "seconds from the log's start, or a utime in us");
  app->add_option("--to", options->to, "the same");
  app->add_flag("--extrinsics",
                options->with_extrinsics,
                "camera poses anew too, from HAND_TO_BASE by the calibration of [extrinsics]");
}

}  // namespace vantage
