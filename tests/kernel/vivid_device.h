#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace vantage {

/// A device of the kernel's vivid driver, opened beside the driver under test to change what it
/// gives, break it, and read back what was set. What the kernel refuses throws std::system_error.
class VividDevice {
 public:
  explicit VividDevice(const std::string& path);
  ~VividDevice();
  VividDevice(const VividDevice&) = delete;
  VividDevice& operator=(const VividDevice&) = delete;

  /// A control by its name in the kernel, such as "Test Pattern"; buttons take any value.
  void Set(const std::string& control, int value);
  [[nodiscard]] int Get(const std::string& control) const;
  /// Back to the values after loading, all of those that tests change.
  void Reset();
  /// Allocates buffers: now nobody else can stream.
  void TakeStream();
  /// One frame as the device gives it, of a format V4L2_PIX_FMT_... and a size in px.
  std::vector<uint8_t> ReadFrame(uint32_t pixel_format, int width, int height);
  /// "platform:vivid-000"
  [[nodiscard]] std::string bus() const;

 private:
  [[nodiscard]] uint32_t Find(const std::string& control) const;

  int file_ = -1;
};

/// Takes all vivid devices away, as unplugging does, or gives them back.
void UnbindVivid();
void BindVivid();

}  // namespace vantage
