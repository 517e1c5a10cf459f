#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace vantage {

/// What the line of sight through a cell of a coarse image tells of a plane.
enum class PlaneSight : uint8_t {
  kOn,      ///< It ends on the plane.
  kHidden,  ///< It ends before the plane, or nothing is measured.
  kBeyond,  ///< It goes through: the plane has no surface there.
};

/// The largest connected patch of a plane in a coarse image. Cells on the plane are linked when
/// they touch, corners included, or lie in one row or column with at most kLongestGap cells
/// between, all hidden. Owns its buffers: allocates nothing once warm.
class PlanePatch {
 public:
  static constexpr int kLongestGap = 8;  ///< cells

  /// @param sights row by row; their number is a multiple of `width`, and not 0.
  void Find(std::span<const PlaneSight> sights, int width);

  /// 1 for cells of the patch; of equal patches the first one's. Valid until the next call.
  [[nodiscard]] std::span<const uint8_t> members() const { return members_; }
  /// Cells of the patch.
  [[nodiscard]] size_t size() const { return size_; }
  /// Lines of sight that go through the plane between two cells of the patch in one row, or in one
  /// column: the larger number. A surface has few of them, a plane across separate surfaces many.
  [[nodiscard]] size_t num_holes() const { return num_holes_; }

 private:
  void Link(std::span<const PlaneSight> sights, int width);
  void KeepLargest();
  [[nodiscard]] size_t CountHoles(std::span<const PlaneSight> sights,
                                  size_t lines,
                                  size_t line_step,
                                  size_t cells,
                                  size_t cell_step) const;
  [[nodiscard]] uint32_t Root(uint32_t cell);
  void Join(uint32_t a, uint32_t b);

  std::vector<uint32_t> parent_;   // Union-find over cells; the smaller index is the root.
  std::vector<uint32_t> sizes_;    // Of a root's patch.
  std::vector<int32_t> last_row_;  // Of each column: of the last cell on the plane, or kNone.
  std::vector<uint8_t> members_;
  size_t size_ = 0;
  size_t num_holes_ = 0;
};

}  // namespace vantage
