#include "tools/monitor/doctor_finding.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/format.h"
#include "tools/monitor/shown_text.h"

namespace vantage {
namespace {

constexpr size_t kLongest = 1000;  // Characters of a sentence.

const char* LevelText(DoctorFinding::Level level) {
  switch (level) {
    case DoctorFinding::Level::kOk:
      return "ok";
    case DoctorFinding::Level::kUnknown:
      return "unknown";
    case DoctorFinding::Level::kWarning:
      return "warning";
    case DoctorFinding::Level::kWrong:
      return "wrong";
  }
  return "";
}

size_t CountOf(const DoctorFindings& findings, DoctorFinding::Level level) {
  return static_cast<size_t>(std::ranges::count(findings, level, &DoctorFinding::level));
}

}  // namespace

int ExitCodeOf(const DoctorFindings& findings) {
  return CountOf(findings, DoctorFinding::Level::kWrong) > 0 ? 1 : 0;
}

std::string DoctorText(const DoctorFindings& findings) {
  std::string text;
  for (const DoctorFinding& each : findings) {
    text += Format("%-8s %-18s ", LevelText(each.level), Shown(each.subject, 40).c_str());
    text += Shown(each.what, kLongest) + "\n";
    if (!each.mend.empty())
      text += "                            $ " + Shown(each.mend, kLongest) + "\n";
  }
  text += Format("%zu ok, %zu unknown, %zu warnings, %zu wrong\n",
                 CountOf(findings, DoctorFinding::Level::kOk),
                 CountOf(findings, DoctorFinding::Level::kUnknown),
                 CountOf(findings, DoctorFinding::Level::kWarning),
                 CountOf(findings, DoctorFinding::Level::kWrong));
  return text;
}

std::string DoctorJson(const DoctorFindings& findings) {
  nlohmann::ordered_json json = {{"ok", ExitCodeOf(findings) == 0},
                                 {"findings", nlohmann::ordered_json::array()}};
  for (const DoctorFinding& each : findings) {
    json["findings"].push_back({{"level", LevelText(each.level)},
                                {"subject", each.subject},
                                {"what", each.what},
                                {"mend", each.mend}});
  }
  return json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace vantage
