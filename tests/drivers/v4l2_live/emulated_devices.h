#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace vantage {

/// The devices that the shim shows to this process, and to those that it starts, for as long as
/// this object lives.
class EmulatedDevices {
 public:
  /// None is plugged in.
  EmulatedDevices();
  ~EmulatedDevices();
  EmulatedDevices(const EmulatedDevices&) = delete;
  EmulatedDevices& operator=(const EmulatedDevices&) = delete;

  /// From now on, these. The language is that of v4l2_shim/description.cc.
  void Describe(const std::string& description) const;
  /// The value that a control of /dev/video<number> has; nothing: it has none, or nobody set any.
  [[nodiscard]] std::optional<int64_t> Control(int number, const std::string& name) const;
  /// For files of tests.
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

}  // namespace vantage
