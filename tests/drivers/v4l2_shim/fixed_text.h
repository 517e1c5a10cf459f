#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>

#include "tests/drivers/v4l2_shim/description.h"

namespace vantage::v4l2_shim {

/// Into a field of fixed size, which the fault "unterminated" fills to the last byte.
template <class Field>
void SetText(const Device& device, const std::string& text, Field& field) {
  constexpr size_t size = sizeof(field);
  const bool unterminated = device.Fault("unterminated", 0) != nullptr;
  std::memset(&field, unterminated ? 'x' : 0, size);
  std::memcpy(&field, text.data(), std::min(text.size(), unterminated ? size : size - 1));
}

}  // namespace vantage::v4l2_shim
