#include "nodes/target_config.h"

#include <array>
#include <string>
#include <utility>

namespace vantage {
namespace {

using Kind = CalibrationTarget::Kind;

constexpr std::array<std::pair<const char*, Kind>, 3> kKinds = {{{"apriltags", Kind::kAprilTags},
                                                                 {"chessboard", Kind::kChessboard},
                                                                 {"charuco", Kind::kCharuco}}};

}  // namespace

void ReadTarget(ConfigReader::Table& table, CalibrationTarget* target) {
  std::string kind = kKinds[static_cast<size_t>(target->kind)].first;
  table.ReadChoice("kind", &kind, {kKinds[0].first, kKinds[1].first, kKinds[2].first});
  for (const auto& [name, value] : kKinds) {
    if (kind == name) target->kind = value;
  }
  constexpr double kSmallest = 1e-4;  // m
  constexpr double kLargest = 10.0;   // m
  table.Read("columns", &target->columns, 1, 100);
  table.Read("rows", &target->rows, 1, 100);
  table.Read("size_m", &target->size, kSmallest, kLargest);
  table.Read("gap_m", &target->gap, 0.0, kLargest);
  table.Read("marker_m", &target->marker, 0.0, kLargest);
  table.Read("first_id", &target->first_id, 0, 100'000);
  table.Read("family", &target->family);
  if (Result<void> sound = target->Validate(); !sound) table.Fail("kind", sound.error().message);
}

}  // namespace vantage
