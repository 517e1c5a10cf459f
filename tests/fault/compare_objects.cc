// compare_objects LOG LOG CONFIG: exits with 0 when two runs end with the same confirmed objects,
// to 1 degree modulo symmetry and 2 mm.
#include <cstdio>
#include <string>
#include <vector>

#include "common/so3.h"
#include "tools/support/recorded_run.h"
#include "tools/support/report_setup.h"
#include "tools/support/run_metrics.h"

namespace vantage {
namespace {

struct Found {
  std::string model_id;
  Pose T_world_object;
};

Result<std::vector<Found>> FinalObjects(const char* log, const std::string& camera) {
  const Result<RecordedRun> run = ReadRun(log, camera);
  if (!run) return run.error();
  std::vector<Found> objects;
  for (const object_estimate_v3_t& object : run->views.back().objects.objects) {
    const std::optional<Pose> pose = EstimatedPose(object);
    if (object.state == object_estimate_v3_t::CONFIRMED && pose) {
      objects.push_back({object.model_id, *pose});
    }
  }
  return objects;
}

bool HasTwin(const Found& object, const std::vector<Found>& others, const ReportSetup& setup) {
  for (const Found& other : others) {
    if (other.model_id != object.model_id) continue;
    const PoseError difference =
        ErrorOf(setup.models.at(object.model_id), object.T_world_object, other.T_world_object);
    if (difference.angle > kDegree || difference.distance > 0.002) continue;
    std::printf("%s: %.2f deg and %.2f mm between the runs\n",
                object.model_id.c_str(),
                difference.angle / kDegree,
                1e3 * difference.distance);
    return true;
  }
  return false;
}

int Compare(const char* first_log, const char* second_log, const char* config) {
  const Result<ReportSetup> setup = LoadReportSetup(config);
  if (!setup) return std::fprintf(stderr, "%s\n", setup.error().message.c_str()), 2;
  const Result<std::vector<Found>> first = FinalObjects(first_log, setup->camera);
  if (!first) return std::fprintf(stderr, "%s\n", first.error().message.c_str()), 2;
  const Result<std::vector<Found>> second = FinalObjects(second_log, setup->camera);
  if (!second) return std::fprintf(stderr, "%s\n", second.error().message.c_str()), 2;
  bool same = first->size() == second->size() && !first->empty();
  for (const Found& object : *first) same = HasTwin(object, *second, *setup) && same;
  if (!same) std::printf("%zu and %zu objects, not the same\n", first->size(), second->size());
  return same ? 0 : 1;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: compare_objects LOG LOG CONFIG\n");
    return 2;
  }
  return vantage::Compare(argv[1], argv[2], argv[3]);
}
