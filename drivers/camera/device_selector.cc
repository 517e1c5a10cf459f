#include "drivers/camera/device_selector.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "common/format.h"

namespace vantage {

Result<DeviceSelector> DeviceSelector::Parse(const std::string& text) {
  const auto rest = [&text](std::string_view prefix) {
    return text.starts_with(prefix) ? text.substr(prefix.size()) : std::string();
  };
  DeviceSelector selector;
  if (const std::string digits = rest("index:"); !digits.empty()) {
    const bool number = digits.size() <= 2 && std::ranges::all_of(digits, [](unsigned char c) {
                          return std::isdigit(c) != 0;
                        });
    if (number) {
      selector.index = std::stoi(digits);
      return selector;
    }
  }
  const struct {
    std::string_view prefix;
    Kind kind;
  } kinds[] = {{"uri:", Kind::kUri}, {"serial:", Kind::kSerial}, {"oni:", Kind::kRecording}};
  for (const auto& each : kinds) {
    selector.kind = each.kind;
    selector.value = rest(each.prefix);
    if (!selector.value.empty()) return selector;
  }
  for (const char* prefix : {"path:", "id:", "bus:"}) {
    if (rest(prefix).empty()) continue;
    selector.kind = Kind::kAlias;
    selector.value = text;
    return selector;
  }
  return Error{ErrorCode::kInvalidArgument,
               Format("device \"%s\", expected \"index:N\" with N from 0 to 99, \"uri:...\", "
                      "\"serial:...\", \"oni:file\", \"path:...\", \"id:...\" or \"bus:...\"",
                      text.c_str())};
}

std::string DeviceSelector::Text() const {
  switch (kind) {
    case Kind::kIndex:
      return Format("index:%d", index);
    case Kind::kUri:
      return "uri:" + value;
    case Kind::kSerial:
      return "serial:" + value;
    case Kind::kRecording:
      return "oni:" + value;
    case Kind::kAlias:
      return value;
  }
  return {};
}

Result<void> CheckRecording(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return Error{ErrorCode::kNotFound,
                 Format("recording %s: no such file, expected an .oni file", path.c_str())};
  }
  constexpr std::string_view kMagic = "NI10";
  std::array<char, kMagic.size()> begin{};
  std::ifstream file(path, std::ios::binary);
  file.read(begin.data(), begin.size());
  if (!file || std::string_view(begin.data(), begin.size()) != kMagic) {
    return Error{ErrorCode::kCorrupt,
                 Format("recording %s: no OpenNI2 recording, which would begin with \"%s\"",
                        path.c_str(),
                        kMagic.data())};
  }
  return {};
}

}  // namespace vantage
