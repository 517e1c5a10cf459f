#include "tools/support/object_table.h"

#include "common/format.h"
#include "common/so3.h"

namespace vantage {
namespace {

const char* StateName(const object_estimate_v3_t& object) {
  switch (object.state) {
    case object_estimate_v3_t::CONFIRMED:
      return object.converged ? "converged" : "confirmed";
    case object_estimate_v3_t::LOST:
      return "lost";
    default:
      return "tentative";
  }
}

}  // namespace

std::string ObjectTable(const object_estimates_v3_t& objects) {
  std::string table = Format("%-16s %8s %-10s %24s %26s %6s\n",
                             "object",
                             "instance",
                             "state",
                             "position (m)",
                             "rotation vector (deg)",
                             "views");
  for (const object_estimate_v3_t& object : objects.objects) {
    Eigen::Vector3d rotation = Eigen::Vector3d::Zero();
    if (!object.peaks.empty()) {
      const Result<Eigen::Quaterniond> q = QuaternionFromWire(object.peaks.front().quat);
      if (q) rotation = LogSo3(*q) / kDegree;
    }
    table += Format("%-16s %8d %-10s %8.4f%8.4f%8.4f %9.2f%8.2f%9.2f %6d\n",
                    object.model_id.c_str(),
                    object.instance_id,
                    StateName(object),
                    object.trans[0],
                    object.trans[1],
                    object.trans[2],
                    rotation.x(),
                    rotation.y(),
                    rotation.z(),
                    object.num_views);
  }
  return table;
}

}  // namespace vantage
