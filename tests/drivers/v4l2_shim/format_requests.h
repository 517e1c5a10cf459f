#pragma once

#include <linux/videodev2.h>

#include "tests/drivers/v4l2_shim/description.h"
#include "tests/drivers/v4l2_shim/device_state.h"

// What a device answers about its formats; all give 0 or an errno.
namespace vantage::v4l2_shim {

int EnumerateFormats(const Device& device, v4l2_fmtdesc* format);
int EnumerateSizes(const Device& device, v4l2_frmsizeenum* size);
int EnumerateIntervals(const Device& device, v4l2_frmivalenum* interval);
int EnumerateInput(const Device& device, v4l2_input* input);
int GetFormat(const DeviceState& state, const Device& device, v4l2_format* format);

/// What the device has that is nearest to `format`, in both.
int ChooseFormat(const Device& device, v4l2_format* format, DeviceState* state);
/// The rate in Hz of the state's format that is nearest to `wanted`.
Fraction NearestRate(const Device& device, const DeviceState& state, Fraction wanted);

}  // namespace vantage::v4l2_shim
