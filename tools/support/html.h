#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace vantage {

/// Text for the content or a quoted attribute of an HTML or SVG element. Control characters that
/// neither may hold become U+FFFD.
std::string EscapeHtml(std::string_view text);

/// RFC 4648 with padding.
std::string Base64(std::span<const uint8_t> bytes);

/// "data:<media_type>;base64,...".
std::string DataUri(std::string_view media_type, std::span<const uint8_t> bytes);
std::string DataUri(std::string_view media_type, std::string_view text);

}  // namespace vantage
