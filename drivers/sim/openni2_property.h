#pragma once

#include <OniCTypes.h>

#include <cstring>

namespace vantage {

/// Copies a value to where OpenNI2 asks for a property. `*size` is the room there, and is set to
/// the value's.
template <class T>
OniStatus PutProperty(const T& value, void* data, int* size) {
  if (data == nullptr || size == nullptr || *size < static_cast<int>(sizeof(T))) {
    return ONI_STATUS_BAD_PARAMETER;
  }
  std::memcpy(data, &value, sizeof(T));
  *size = static_cast<int>(sizeof(T));
  return ONI_STATUS_OK;
}

/// Copies a property that OpenNI2 sets; false when the size is another type's.
template <class T>
bool TakeProperty(const void* data, int size, T* value) {
  if (data == nullptr || size != static_cast<int>(sizeof(T))) return false;
  std::memcpy(value, data, sizeof(T));
  return true;
}

}  // namespace vantage
