#include "perception/calibration/tag_family.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagStandard41h12.h>

#include <array>
#include <cstdlib>

#include "common/check.h"

namespace vantage {
namespace {

struct Entry {
  const char* name;
  apriltag_family_t* (*create)();
  void (*destroy)(apriltag_family_t*);
};

constexpr std::array kFamilies = {
    Entry{"tag36h11", tag36h11_create, tag36h11_destroy},
    Entry{"tag25h9", tag25h9_create, tag25h9_destroy},
    Entry{"tag16h5", tag16h5_create, tag16h5_destroy},
    Entry{"tagStandard41h12", tagStandard41h12_create, tagStandard41h12_destroy},
};

}  // namespace

Result<TagFamily> TagFamily::Find(std::string_view name) {
  std::string known;
  for (const Entry& entry : kFamilies) {
    if (name == entry.name) return TagFamily(entry.create(), entry.destroy);
    if (!known.empty()) known += ", ";
    known += entry.name;
  }
  std::string message = "unknown family of tags \"";
  message.append(name.substr(0, 64)).append("\", expected one of ").append(known);
  return Error{ErrorCode::kInvalidArgument, std::move(message)};
}

int TagFamily::num_tags() const { return static_cast<int>(family_->ncodes); }

int TagFamily::border_cells() const { return family_->width_at_border; }

int TagFamily::outer_cells() const { return (family_->total_width - family_->width_at_border) / 2; }

bool TagFamily::has_plain_ring() const { return !family_->reversed_border; }

std::vector<bool> TagFamily::BlackCells(int id) const {
  VANTAGE_CHECK(id >= 0 && id < num_tags(), std::to_string(id));
  // Debian's library does not export image_u8_destroy(), which does just this.
  const auto destroy = [](image_u8_t* picture) {
    std::free(picture->buf);
    std::free(picture);
  };
  const std::unique_ptr<image_u8_t, decltype(destroy)> image(apriltag_to_image(family_.get(), id),
                                                             destroy);
  std::vector<bool> black;
  for (int v = 0; v < image->height; ++v) {
    for (int u = 0; u < image->width; ++u) black.push_back(image->buf[v * image->stride + u] < 128);
  }
  return black;
}

}  // namespace vantage
