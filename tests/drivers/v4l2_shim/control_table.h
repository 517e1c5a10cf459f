#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace vantage::v4l2_shim {

/// A control as the kernel knows it.
struct KnownControl {
  const char* name;   ///< in the description
  uint32_t id;        ///< V4L2_CID_...
  const char* title;  ///< the kernel's name for it
  uint32_t type;      ///< V4L2_CTRL_TYPE_...
  std::vector<const char*> menu;
  const char* master;  ///< control that must have the value `manual`, or this is inactive; null
  int32_t manual;
};

/// By ascending id, with the titles of their classes among them.
std::span<const KnownControl> KnownControls();
/// Null: none.
const KnownControl* FindControl(uint32_t id);
const KnownControl* FindControl(const std::string& name);

}  // namespace vantage::v4l2_shim
