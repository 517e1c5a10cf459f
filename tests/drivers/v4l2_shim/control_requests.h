#pragma once

#include <filesystem>

#include "tests/drivers/v4l2_shim/description.h"

namespace vantage::v4l2_shim {

/// VIDIOC_QUERYCTRL, _QUERY_EXT_CTRL, _QUERYMENU, _G_CTRL, _S_CTRL, _G/_TRY/_S_EXT_CTRLS.
/// @return 0 or an errno; ENOTTY: another request.
int ControlIoctl(const std::filesystem::path& root,
                 const Device& device,
                 unsigned long request,
                 void* argument);

}  // namespace vantage::v4l2_shim
