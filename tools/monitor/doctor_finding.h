#pragma once

#include <string>
#include <vector>

namespace vantage {

/// One line of what vantage-doctor says.
struct DoctorFinding {
  enum class Level {
    kOk,
    kUnknown,  ///< it can't be told here; `what` says why
    kWarning,  ///< it works, but something will not
    kWrong,
  };
  Level level = Level::kOk;
  std::string subject;  ///< "multicast route"
  std::string what;     ///< one sentence, fit to be shown
  std::string mend;     ///< the shell command that mends it; empty: none does
};

using DoctorFindings = std::vector<DoctorFinding>;

/// 1 if something is wrong, else 0.
int ExitCodeOf(const DoctorFindings& findings);

/// A line for each, with the command below it, and a last one that counts.
std::string DoctorText(const DoctorFindings& findings);
/// {"ok", "findings": [{"level", "subject", "what", "mend"}]}
std::string DoctorJson(const DoctorFindings& findings);

}  // namespace vantage
