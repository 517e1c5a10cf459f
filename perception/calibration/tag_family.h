#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

struct apriltag_family;

namespace vantage {

/// A family of AprilTags (Wang, Olson, "AprilTag 2: Efficient and robust fiducial detection", IROS
/// 2016), as libapriltag knows it. To a detector it belongs alone: libapriltag keeps tables in it.
class TagFamily {
 public:
  /// Errors: an unknown name (the sentence names those that there are).
  static Result<TagFamily> Find(std::string_view name);

  [[nodiscard]] int num_tags() const;
  /// Cells along a tag's side between the corners that a detector reports.
  [[nodiscard]] int border_cells() const;
  /// Cells around that square that belong to the tag: a white ring, or one with data.
  [[nodiscard]] int outer_cells() const;
  /// Whether the cells around the square may be shared with the neighbor's: a plain white ring.
  [[nodiscard]] bool has_plain_ring() const;
  /// Whether cells are black, row by row, border_cells() + 2 outer_cells() each way. id <
  /// num_tags().
  [[nodiscard]] std::vector<bool> BlackCells(int id) const;

  [[nodiscard]] apriltag_family* get() const { return family_.get(); }

 private:
  using Destroy = void (*)(apriltag_family*);
  TagFamily(apriltag_family* family, Destroy destroy) : family_(family, destroy) {}

  std::unique_ptr<apriltag_family, Destroy> family_;
};

}  // namespace vantage
