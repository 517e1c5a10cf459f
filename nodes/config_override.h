#pragma once

#include <string>
#include <vector>

#include "common/result.h"

namespace vantage {

/// A value that goes before the one of the configuration's text: "fusion.sigma_deg=6".
struct ConfigOverride {
  std::string key;      ///< "fusion.refinement.camera", "sim.object[1].model"
  std::string literal;  ///< the value as TOML
};

/// Reads "table.key=value". The value is any TOML value; what is none, and does not begin like a
/// text in quotes or a table, is taken as a text, also inside of [a, b].
/// Errors: no "=", no value, a key that is none, a value that is broken TOML.
Result<ConfigOverride> ParseConfigOverride(const std::string& setting);

/// The text with the values of the overrides, in their order; comments and all else stay. Tables
/// that are absent come to be; whether a key or value means something, its readers say.
/// Errors: no TOML; a key below something that is no table; an index that does not exist.
Result<std::string> OverriddenConfigText(const std::string& text,
                                         const std::vector<ConfigOverride>& overrides);

}  // namespace vantage
