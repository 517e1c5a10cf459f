#include "tools/replay/sweep_grid.h"

#include <toml++/toml.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "common/format.h"
#include "nodes/config_reader.h"

namespace vantage {
namespace {

std::string TomlText(const toml::node& node) {
  std::ostringstream stream;
  node.visit([&stream](const auto& value) { stream << value; });
  return stream.str();
}

struct Placed {
  toml::source_position position;
  SweepParameter parameter;
};

Result<void> Gather(const toml::table& table,
                    const std::string& prefix,
                    std::vector<Placed>* parameters) {
  for (const auto& [key, node] : table) {
    const std::string name = prefix + std::string(key.str());
    if (const toml::table* below = node.as_table()) {
      if (Result<void> gathered = Gather(*below, name + ".", parameters); !gathered) {
        return gathered;
      }
      continue;
    }
    const toml::array* values = node.as_array();
    if (values == nullptr || values->empty()) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("grid: %s = %s: expected a list of values, such as [2, 4, 8]",
                          name.c_str(),
                          TomlText(node).c_str())};
    }
    Placed placed{node.source().begin, {name, {}}};
    for (const toml::node& value : *values) {
      const Result<ConfigOverride> setting = ParseConfigOverride(name + "=" + TomlText(value));
      if (!setting) return Error{setting.error().code, "grid: " + setting.error().message};
      placed.parameter.literals.push_back(setting->literal);
    }
    parameters->push_back(std::move(placed));
  }
  return {};
}

Result<SweepGrid> Parse(const std::string& text) {
  const toml::table root = toml::parse(text);
  const toml::table* table = root["grid"].as_table();
  if (table == nullptr || table->empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "expected a table [grid] with lists such as \"fusion.sigma_deg\" = [2, 4, 8]"};
  }
  for (const auto& [key, node] : root) {
    if (key.str() == "grid") continue;
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s: unknown key; known here: grid", std::string(key.str()).c_str())};
  }
  std::vector<Placed> placed;
  if (Result<void> gathered = Gather(*table, "", &placed); !gathered) return gathered.error();
  std::ranges::sort(placed, [](const Placed& a, const Placed& b) {
    return std::pair(a.position.line, a.position.column) <
           std::pair(b.position.line, b.position.column);
  });
  SweepGrid grid;
  size_t num_cells = 1;
  for (Placed& each : placed) {
    num_cells *= each.parameter.literals.size();
    if (num_cells > kMostSweepCells) {
      return Error{
          ErrorCode::kInvalidArgument,
          Format("grid has more than %zu cells, expected so many at most", kMostSweepCells)};
    }
    grid.parameters.push_back(std::move(each.parameter));
  }
  return grid;
}

}  // namespace

size_t SweepGrid::num_cells() const {
  size_t number = 1;
  for (const SweepParameter& each : parameters) number *= each.literals.size();
  return number;
}

std::vector<size_t> SweepGrid::Places(size_t cell) const {
  std::vector<size_t> places(parameters.size());
  for (size_t i = parameters.size(); i-- > 0;) {
    places[i] = cell % parameters[i].literals.size();
    cell /= parameters[i].literals.size();
  }
  return places;
}

std::vector<ConfigOverride> SweepGrid::Overrides(size_t cell) const {
  std::vector<ConfigOverride> overrides;
  const std::vector<size_t> places = Places(cell);
  for (size_t i = 0; i < parameters.size(); ++i) {
    overrides.push_back({parameters[i].key, parameters[i].literals[places[i]]});
  }
  return overrides;
}

std::string SweepGrid::CellText(size_t cell) const {
  std::string text;
  for (const ConfigOverride& each : Overrides(cell)) {
    text += (text.empty() ? "" : ", ") + each.key;
    text += " = " + each.literal;
  }
  return text;
}

Result<SweepGrid> ReadSweepGrid(const std::filesystem::path& file) {
  // What can be wrong with a file of TOML, is told there.
  const Result<ConfigReader> opened = ConfigReader::Open(file);
  if (!opened) return opened.error();
  Result<SweepGrid> grid = Parse(opened->text());
  if (!grid) return Error{grid.error().code, file.string() + ": " + grid.error().message};
  return grid;
}

}  // namespace vantage
