#include "nodes/config_override.h"

#include <toml++/toml.h>

#include <algorithm>
#include <optional>
#include <regex>
#include <sstream>
#include <string_view>

#include "common/format.h"
#include "nodes/toml_position.h"

namespace vantage {
namespace {

// A part of a key: "object[1]".
struct Part {
  std::string name;
  std::optional<size_t> index;
};

std::string Trimmed(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

std::optional<toml::table> ParseToml(const std::string& text) {
  try {
    return toml::parse(text);
  } catch (const toml::parse_error&) {
    return std::nullopt;
  }
}

std::string TextLiteral(const std::string& text) {
  std::ostringstream stream;
  stream << toml::value<std::string>(text);
  return stream.str();
}

// A value as TOML; nothing where it is broken.
std::optional<std::string> Literal(const std::string& value) {
  constexpr std::string_view kStructured = "[{\"'";
  const bool is_list = value.size() > 1 && value.front() == '[' && value.back() == ']';
  // Such a value might end the line that it is put into, or the line its rest.
  if (value.empty() || value.find_first_of("\n\r#") != std::string::npos) {
    if (value.empty() || kStructured.find(value.front()) != std::string_view::npos) {
      return std::nullopt;
    }
    return TextLiteral(value);
  }
  const std::optional<toml::table> parsed = ParseToml("value = " + value);
  if (parsed && parsed->size() == 1) return value;
  if (!is_list && kStructured.find(value.front()) != std::string_view::npos) return std::nullopt;
  if (!is_list) return TextLiteral(value);
  std::string list;
  std::istringstream elements(value.substr(1, value.size() - 2));
  for (std::string element; std::getline(elements, element, ',');) {
    const std::optional<std::string> literal = Literal(Trimmed(element));
    if (!literal) return std::nullopt;
    list += (list.empty() ? "" : ", ") + *literal;
  }
  return "[" + list + "]";
}

std::vector<Part> PartsOf(const std::string& key) {
  std::vector<Part> parts;
  std::istringstream stream(key);
  for (std::string name; std::getline(stream, name, '.');) {
    Part part{name, std::nullopt};
    if (const size_t bracket = name.find('['); bracket != std::string::npos) {
      part.name = name.substr(0, bracket);
      part.index = std::stoul(name.substr(bracket + 1));
    }
    parts.push_back(part);
  }
  return parts;
}

Error KeyError(const std::string& key, const std::string& what) {
  return {ErrorCode::kInvalidArgument, key + ": " + what};
}

// Where a value stands or would stand.
struct Place {
  toml::table* table = nullptr;  // Null: the innermost table is absent.
  toml::node* value = nullptr;   // Null: absent.
};

Result<Place> Find(toml::table& root, const std::string& key) {
  const std::vector<Part> parts = PartsOf(key);
  toml::table* table = &root;
  for (size_t i = 0; i < parts.size(); ++i) {
    const bool is_last = i + 1 == parts.size();
    toml::node* node = table->get(parts[i].name);
    if (parts[i].index) {
      toml::array* list = node == nullptr ? nullptr : node->as_array();
      const size_t size = list == nullptr ? 0 : list->size();
      if (*parts[i].index >= size) {
        return KeyError(key, Format("%s has %zu elements", parts[i].name.c_str(), size));
      }
      node = list->get(*parts[i].index);
    }
    if (is_last) return Place{table, node};
    if (node == nullptr) {
      for (size_t k = i + 1; k < parts.size(); ++k) {
        if (parts[k].index) return KeyError(key, parts[k].name + " has 0 elements");
      }
      return Place{};
    }
    table = node->as_table();
    if (table == nullptr) return KeyError(key, parts[i].name + " is no table");
  }
  return Place{};
}

void Set(toml::table& root, const ConfigOverride& setting) {
  const toml::table parsed = toml::parse("value = " + setting.literal);
  toml::table* table = &root;
  const std::vector<Part> parts = PartsOf(setting.key);
  for (size_t i = 0; i < parts.size(); ++i) {
    const bool is_last = i + 1 == parts.size();
    if (is_last && !parts[i].index) {
      table->insert_or_assign(parts[i].name, *parsed.get("value"));
      return;
    }
    toml::node* node = table->get(parts[i].name);
    if (node == nullptr) {
      table->insert(parts[i].name, toml::table());
      node = table->get(parts[i].name);
    }
    if (parts[i].index && is_last) {
      toml::array& list = *node->as_array();
      const auto at = list.begin() + static_cast<std::ptrdiff_t>(*parts[i].index);
      list.insert(list.erase(at), *parsed.get("value"));
      return;
    }
    if (parts[i].index) node = node->as_array()->get(*parts[i].index);
    table = node->as_table();
  }
}

// The text with one more value in the table where it belongs, or in a new one at the end. Right for
// tables under a header of their own; the caller checks.
std::string Edited(std::string text,
                   const ConfigOverride& setting,
                   const Place& place,
                   bool in_new_table) {
  if (place.value != nullptr) {
    const size_t begin = OffsetOf(text, place.value->source().begin);
    const size_t end = OffsetOf(text, place.value->source().end);
    return begin < end ? text.replace(begin, end - begin, setting.literal) : text;
  }
  const size_t dot = setting.key.rfind('.');
  const std::string key = setting.key.substr(dot == std::string::npos ? 0 : dot + 1);
  const std::string line = key + " = " + setting.literal + "\n";
  if (dot == std::string::npos) return line + text;
  if (!text.empty() && text.back() != '\n') text += '\n';
  if (in_new_table) return text + "\n[" + setting.key.substr(0, dot) + "]\n" + line;
  if (place.table == nullptr) return text;
  const size_t after = text.find('\n', OffsetOf(text, place.table->source().begin));
  return text.insert(std::min(after, text.size() - 1) + 1, line);
}

Result<std::string> WithOverride(const std::string& text, const ConfigOverride& setting) {
  toml::table root = toml::parse(text);
  const Result<Place> place = Find(root, setting.key);
  if (!place) return place.error();
  std::vector<std::string> candidates;
  for (const bool in_new_table : {false, true}) {
    candidates.push_back(Edited(text, setting, *place, in_new_table));
  }
  Set(root, setting);
  for (const std::string& candidate : candidates) {
    const std::optional<toml::table> check = ParseToml(candidate);
    if (check && *check == root) return candidate;
  }
  // The file is written in a way that the edit is no match for: without its comments then.
  std::ostringstream whole;
  whole << root << "\n";
  return whole.str();
}

}  // namespace

Result<ConfigOverride> ParseConfigOverride(const std::string& setting) {
  const size_t equals = setting.find('=');
  const std::string key = Trimmed(setting.substr(0, equals));
  static const std::regex form(R"([\w-]+(\[\d{1,6}\])?(\.[\w-]+(\[\d{1,6}\])?)*)");
  if (equals == std::string::npos || !std::regex_match(key, form)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("'%s' is no setting, expected table.key=value, such as fusion.sigma_deg=4",
                        setting.c_str())};
  }
  const std::string value = Trimmed(setting.substr(equals + 1));
  if (value.empty()) return KeyError(key, "the value is missing, expected " + key + "=value");
  const std::optional<std::string> literal = Literal(value);
  if (!literal) return KeyError(key, "'" + value + "' is no TOML value");
  return ConfigOverride{key, *literal};
}

Result<std::string> OverriddenConfigText(const std::string& text,
                                         const std::vector<ConfigOverride>& overrides) {
  if (!ParseToml(text)) return Error{ErrorCode::kCorrupt, "the configuration is no valid TOML"};
  std::string result = text;
  for (const ConfigOverride& each : overrides) {
    Result<std::string> next = WithOverride(result, each);
    if (!next) return next.error();
    result = std::move(next).value();
  }
  return result;
}

}  // namespace vantage
