#include "tools/support/comparison_arguments.h"

namespace vantage {

void AddToleranceArguments(CLI::App* app, ComparisonTolerance* tolerance) {
  const auto add = [app](const char* name, double* value, const char* meaning) {
    app->add_option(name, *value, meaning)
        ->capture_default_str()
        ->check(CLI::NonNegativeNumber)
        ->group("Comparing");
  };
  add("--position-tolerance-mm", &tolerance->position_mm, "by which positions may differ");
  add("--angle-tolerance-deg", &tolerance->angle_deg, "by which orientations may differ");
  add("--absolute-tolerance", &tolerance->absolute, "by which other real numbers may differ, or");
  add("--relative-tolerance", &tolerance->relative, "as a share of the recorded one; added");
}

}  // namespace vantage
