#pragma once

#include <filesystem>
#include <string>

namespace vantage {

/// Who may open a USB device that OpenNI2 names "vendor/product@bus/device", as the end of a
/// sentence, where this user may not; empty where it may, or the URI names no such device.
std::string UsbPermissionHint(const std::string& uri,
                              const std::filesystem::path& usb_folder = "/dev/bus/usb");

}  // namespace vantage
