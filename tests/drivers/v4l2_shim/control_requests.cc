#include "tests/drivers/v4l2_shim/control_requests.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string>

#include "tests/drivers/v4l2_shim/control_table.h"
#include "tests/drivers/v4l2_shim/device_state.h"
#include "tests/drivers/v4l2_shim/fixed_text.h"

namespace vantage::v4l2_shim {
namespace {

const ControlValue* OfDevice(const Device& device, const KnownControl* known) {
  if (known == nullptr) return nullptr;
  const auto found = std::ranges::find(device.controls, known->name, &ControlValue::name);
  return found == device.controls.end() ? nullptr : &*found;
}

bool HasClass(const Device& device, uint32_t title_id) {
  return std::ranges::any_of(device.controls, [title_id](const ControlValue& control) {
    const KnownControl* known = FindControl(control.name);
    return known != nullptr && V4L2_CTRL_ID2CLASS(known->id) == V4L2_CTRL_ID2CLASS(title_id);
  });
}

bool IsThere(const Device& device, const KnownControl& known) {
  return known.type == V4L2_CTRL_TYPE_CTRL_CLASS ? HasClass(device, known.id)
                                                 : OfDevice(device, &known) != nullptr;
}

// The control of that id, or the first after it where it says so; null: none.
const KnownControl* Asked(const Device& device, uint32_t id) {
  constexpr uint32_t kFlags = V4L2_CTRL_FLAG_NEXT_CTRL | V4L2_CTRL_FLAG_NEXT_COMPOUND;
  const KnownControl* found = nullptr;
  for (const KnownControl& known : KnownControls()) {
    if (!IsThere(device, known)) continue;
    if ((id & kFlags) == 0 ? known.id != id : known.id <= (id & ~kFlags)) continue;
    if ((id & kFlags) == V4L2_CTRL_FLAG_NEXT_COMPOUND) continue;
    if (found == nullptr || known.id < found->id) found = &known;
  }
  if (found == nullptr && (id & kFlags) != 0 && device.Fault("endless", 0) != nullptr) {
    return Asked(device, V4L2_CTRL_FLAG_NEXT_CTRL);
  }
  return found;
}

uint32_t FlagsOf(const DeviceState& state, const KnownControl& known) {
  if (known.type == V4L2_CTRL_TYPE_CTRL_CLASS) {
    return V4L2_CTRL_FLAG_READ_ONLY | V4L2_CTRL_FLAG_WRITE_ONLY;
  }
  const bool is_master = std::ranges::any_of(KnownControls(), [&](const KnownControl& other) {
    return other.master != nullptr && std::strcmp(other.master, known.name) == 0;
  });
  return (IsInactive(state, known.name) ? V4L2_CTRL_FLAG_INACTIVE : 0U) |
         (is_master ? V4L2_CTRL_FLAG_UPDATE : 0U);
}

template <class Query>
int Describe(const Device& device, const DeviceState& state, Query* query) {
  const KnownControl* known = Asked(device, query->id);
  if (known == nullptr) return EINVAL;
  *query = Query{};
  query->id = known->id;
  query->type = known->type;
  SetText(device, known->title, query->name);
  if (const ControlValue* control = OfDevice(device, known)) {
    query->minimum = control->minimum;
    query->maximum = control->maximum;
    query->step = static_cast<decltype(query->step)>(control->step);
    query->default_value = control->initial;
  }
  query->flags = FlagsOf(state, *known);
  return 0;
}

int QueryMenu(const Device& device, v4l2_querymenu* menu) {
  const KnownControl* known = FindControl(menu->id);
  const ControlValue* control = OfDevice(device, known);
  if (control == nullptr || known->menu.empty() || menu->index >= known->menu.size() ||
      menu->index > static_cast<uint32_t>(control->maximum) ||
      static_cast<int32_t>(menu->index) < control->minimum) {
    return EINVAL;
  }
  menu->reserved = 0;
  std::array<char, sizeof(menu->name)> name{};  // The menu's own is packed.
  SetText(device, known->menu[menu->index], name);
  std::memcpy(menu->name, name.data(), name.size());
  return 0;
}

// As the kernel's framework does: numbers are moved to the nearest that is allowed.
int Set(const Device& device, uint32_t id, int32_t* value, DeviceState* state) {
  const KnownControl* known = FindControl(id);
  if (known != nullptr && known->type == V4L2_CTRL_TYPE_CTRL_CLASS && IsThere(device, *known)) {
    return EACCES;
  }
  const ControlValue* control = OfDevice(device, known);
  if (control == nullptr) return EINVAL;
  if (known->type == V4L2_CTRL_TYPE_MENU &&
      (*value < control->minimum || *value > control->maximum)) {
    return ERANGE;
  }
  if (known->type == V4L2_CTRL_TYPE_BOOLEAN) *value = *value != 0 ? 1 : 0;
  *value = std::clamp(*value, control->minimum, control->maximum);
  *value = control->minimum + (*value - control->minimum) / control->step * control->step;
  if (IsInactive(*state, known->name)) return EACCES;
  state->controls[known->name] = *value;
  return 0;
}

int Get(const Device& device, uint32_t id, int32_t* value, const DeviceState& state) {
  const KnownControl* known = FindControl(id);
  if (known != nullptr && known->type == V4L2_CTRL_TYPE_CTRL_CLASS && IsThere(device, *known)) {
    return EACCES;
  }
  if (OfDevice(device, known) == nullptr) return EINVAL;
  *value = state.controls.at(known->name);
  return 0;
}

int Extended(const std::filesystem::path& root,
             const Device& device,
             unsigned long request,
             v4l2_ext_controls* list) {
  if (list->which == V4L2_CTRL_WHICH_REQUEST_VAL) return EINVAL;
  if (list->count == 0) {
    const bool known = list->which == V4L2_CTRL_WHICH_CUR_VAL ||
                       list->which == V4L2_CTRL_WHICH_DEF_VAL || HasClass(device, list->which | 1U);
    return known ? 0 : EINVAL;
  }
  DeviceState state = LoadState(root, device);
  if (list->which == V4L2_CTRL_WHICH_DEF_VAL) {
    if (request != VIDIOC_G_EXT_CTRLS) return EINVAL;
    for (const ControlValue& control : device.controls) {
      state.controls[control.name] = control.initial;
    }
  }
  for (uint32_t i = 0; i < list->count; ++i) {
    v4l2_ext_control& control = list->controls[i];
    // Only trying tells which one is wrong before any is touched.
    list->error_idx = request == VIDIOC_TRY_EXT_CTRLS ? i : list->count;
    int32_t value = control.value;
    const int error = request == VIDIOC_G_EXT_CTRLS ? Get(device, control.id, &value, state)
                                                    : Set(device, control.id, &value, &state);
    control.value = value;
    if (error != 0) return error;
  }
  if (request == VIDIOC_S_EXT_CTRLS) SaveState(root, device, state);
  return 0;
}

}  // namespace

int ControlIoctl(const std::filesystem::path& root,
                 const Device& device,
                 unsigned long request,
                 void* argument) {
  if (device.controls.empty()) return ENOTTY;
  switch (request) {
    case VIDIOC_QUERYCTRL:
      return Describe(device, LoadState(root, device), static_cast<v4l2_queryctrl*>(argument));
    case VIDIOC_QUERY_EXT_CTRL: {
      auto* query = static_cast<v4l2_query_ext_ctrl*>(argument);
      const int error = Describe(device, LoadState(root, device), query);
      if (error == 0) {
        query->elem_size = sizeof(int32_t);
        query->elems = 1;
      }
      return error;
    }
    case VIDIOC_QUERYMENU:
      return QueryMenu(device, static_cast<v4l2_querymenu*>(argument));
    case VIDIOC_G_CTRL: {
      auto* control = static_cast<v4l2_control*>(argument);
      return Get(device, control->id, &control->value, LoadState(root, device));
    }
    case VIDIOC_S_CTRL: {
      auto* control = static_cast<v4l2_control*>(argument);
      DeviceState state = LoadState(root, device);
      const int error = Set(device, control->id, &control->value, &state);
      if (error == 0) SaveState(root, device, state);
      return error;
    }
    case VIDIOC_G_EXT_CTRLS:
    case VIDIOC_S_EXT_CTRLS:
    case VIDIOC_TRY_EXT_CTRLS:
      return Extended(root, device, request, static_cast<v4l2_ext_controls*>(argument));
    default:
      return ENOTTY;
  }
}

}  // namespace vantage::v4l2_shim
