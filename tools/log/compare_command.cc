#include "tools/log/compare_command.h"

#include <cstdio>

#include "common/format.h"
#include "tools/support/comparison_arguments.h"
#include "tools/support/log_comparison.h"

namespace vantage {

CompareCommand::CompareCommand(CLI::App* app)
    : command_(app->add_subcommand(
          "compare", "whether two logs hold the same messages; exits 1 where they do not")) {
  command_->add_option("first", first_, "LCM event log")->required();
  command_->add_option("second", second_, "LCM event log")->required();
  command_
      ->add_option("--channels",
                   channels_,
                   "regular expression for the whole name; default: all but LOG_HEADER and "
                   "PROCESS_STATUS, which differ between any two runs")
      ->group("Comparing");
  AddToleranceArguments(command_, &tolerance_);
}

Result<int> CompareCommand::Run() const {
  const Result<LogComparison> comparison = CompareLogs(first_, second_, channels_, tolerance_);
  if (!comparison) return comparison.error();
  if (comparison->num_compared() == 0) {
    return Error{ErrorCode::kNotFound,
                 Format("neither %s nor %s has a message on '%s', expected some to compare",
                        first_.c_str(),
                        second_.c_str(),
                        channels_.c_str())};
  }
  std::printf("%s", ComparisonText(*comparison, {"first", "second"}).c_str());
  return comparison->clean() ? 0 : 1;
}

}  // namespace vantage
