#pragma once

#include <toml++/toml.h>

#include <algorithm>
#include <cstddef>
#include <string>

namespace vantage {

/// The byte of a text at a line and column, both from 1; TOML counts columns in code points.
inline size_t OffsetOf(const std::string& text, toml::source_position position) {
  size_t at = 0;
  for (toml::source_index line = 1; line < position.line && at < text.size(); ++line) {
    at = std::min(text.find('\n', at), text.size() - 1) + 1;
  }
  for (toml::source_index column = 1; column < position.column && at < text.size(); ++column) {
    do {
      ++at;
    } while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U);
  }
  return at;
}

}  // namespace vantage
