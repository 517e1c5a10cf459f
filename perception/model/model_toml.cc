#include "perception/model/model_toml.h"

#include <toml++/toml.h>

#include <charconv>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

#include "common/format.h"
#include "common/so3.h"
#include "perception/model/symmetry_text.h"

namespace vantage {
namespace {

using Kind = SymmetryDescription::Kind;

constexpr int64_t kMostSamples = 1'000'000;
constexpr size_t kMostElements = 2000;

// A quoted TOML string; control characters become blanks.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
  }
  return quoted + "\"";
}

// Shortest text that reads back as the same number, always with a point or an exponent.
std::string Number(double value) {
  std::array<char, 32> buffer{};
  const auto [end, error] =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value + 0.0);
  std::string text(buffer.data(), end);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

// "[1.0, 2.0, 3.0]".
template <int kSize>
std::string Numbers(const Eigen::Matrix<double, kSize, 1>& values) {
  std::string text = "[";
  for (const double value : values) {
    if (text.size() > 1) text.append(", ");
    text.append(Number(value));
  }
  text.append("]");
  return text;
}

// Reads the keys of one table; remembers the first thing that is wrong.
class TableReader {
 public:
  TableReader(const toml::table& table, std::string place)
      : table_(table), place_(std::move(place)) {}

  std::string String(std::string_view key) {
    const std::optional<std::string> value = table_[key].value_exact<std::string>();
    if (!value) Fail(key, "a string");
    return value.value_or("");
  }
  bool Bool(std::string_view key) {
    const std::optional<bool> value = table_[key].value_exact<bool>();
    if (!value) Fail(key, "true or false");
    return value.value_or(false);
  }
  int64_t Integer(std::string_view key, int64_t lowest, int64_t highest) {
    const std::optional<int64_t> value = table_[key].value_exact<int64_t>();
    if (!value || *value < lowest || *value > highest) {
      Fail(key, "a whole number from " + std::to_string(lowest) + " to " + std::to_string(highest));
      return lowest;
    }
    return *value;
  }
  double Positive(std::string_view key) {
    const std::optional<double> value = table_[key].value<double>();
    if (!value || !(*value > 0.0) || !std::isfinite(*value)) Fail(key, "a positive number");
    return value.value_or(1.0);
  }
  template <int kSize>
  Eigen::Matrix<double, kSize, 1> Numbers(const toml::node_view<const toml::node>& node,
                                          std::string_view key) {
    Eigen::Matrix<double, kSize, 1> vector = Eigen::Matrix<double, kSize, 1>::Zero();
    const toml::array* array = node.as_array();
    bool fits = array != nullptr && array->size() == kSize;
    for (int i = 0; fits && i < kSize; ++i) {
      const std::optional<double> value = array->get(static_cast<size_t>(i))->value<double>();
      fits = value && std::isfinite(*value) && std::abs(*value) < 1e6;
      vector[i] = value.value_or(0.0);
    }
    if (!fits) Fail(key, std::to_string(kSize) + " numbers");
    return vector;
  }
  Eigen::Vector3d Vector(std::string_view key) { return Numbers<3>(table_[key], key); }

  void Known(std::initializer_list<std::string_view> keys) {
    for (const auto& [key, value] : table_) {
      bool known = false;
      for (const std::string_view name : keys) known = known || name == key.str();
      if (!known) Fail(key.str(), "no such key");
    }
  }
  void Fail(std::string_view key, const std::string& expectation) {
    if (error_) return;
    std::string found = "is absent";
    if (const toml::node_view<const toml::node> node = table_[key]; node) {
      std::ostringstream text;
      text << node;
      found = "= " + text.str().substr(0, 80);
    }
    error_ = Error{ErrorCode::kInvalidArgument,
                   Format("%s: key %.*s %s, expected %s",
                          place_.c_str(),
                          static_cast<int>(key.size()),
                          key.data(),
                          found.c_str(),
                          expectation.c_str())};
  }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

 private:
  const toml::table& table_;
  std::string place_;
  std::optional<Error> error_;
};

std::string SymmetryTable(const SymmetryGroup& group) {
  const SymmetryDescription description = DescribeSymmetry(group);
  const std::string order = "order = " + std::to_string(description.order) + "\n";
  const std::string axis = "axis = " + Numbers(description.axis) + "\n";
  switch (description.kind) {
    case Kind::kNone:
      return "kind = \"none\"\n";
    case Kind::kCyclic:
      return "kind = \"cyclic\"\n" + order + axis;
    case Kind::kDihedral:
      return "kind = \"dihedral\"\n" + order + axis +
             "half_turn_axis = " + Numbers(description.half_turn_axis) + "\n";
    case Kind::kContinuous:
      return "kind = \"continuous\"\n" + axis +
             "flips = " + (description.flips ? "true" : "false") + "\n";
    case Kind::kFinite:
      break;
  }
  std::string text = "kind = \"finite\"\nelements_wxyz = [\n";
  for (const Eigen::Quaterniond& q : group.elements) {
    text += "  " + Numbers(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z())) + ",\n";
  }
  return text + "]\n";
}

Result<SymmetryGroup> ReadElements(const toml::table& table, const std::string& place) {
  TableReader reader(table, place);
  reader.Known({"kind", "elements_wxyz"});
  SymmetryGroup group;
  group.elements.clear();
  const toml::array* rows = table["elements_wxyz"].as_array();
  if (rows == nullptr || rows->empty() || rows->size() > kMostElements) {
    reader.Fail("elements_wxyz", Format("1 to %zu quaternions", kMostElements));
    return *reader.error();
  }
  for (const toml::node& row : *rows) {
    const Eigen::Vector4d wxyz =
        reader.Numbers<4>(toml::node_view<const toml::node>(row), "elements_wxyz");
    if (reader.error()) return *reader.error();
    const std::array<double, 4> values = {wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
    const Result<Eigen::Quaterniond> q = QuaternionFromWire(values);
    if (!q) return Error{q.error().code, place + ": " + q.error().message};
    group.elements.push_back(*q);
  }
  if (reader.error()) return *reader.error();
  if (GeodesicAngle(group.elements.front(), Eigen::Quaterniond::Identity()) > 1e-6) {
    return Error{ErrorCode::kInvalidArgument,
                 place + ": the first of elements_wxyz is not the identity"};
  }
  return group;
}

Result<SymmetryGroup> ReadSymmetry(const toml::table& table, const std::string& place) {
  TableReader reader(table, place);
  SymmetryDescription description;
  const std::string kind = reader.String("kind");
  if (kind == "finite") return ReadElements(table, place);
  if (kind == "none") {
    reader.Known({"kind"});
  } else if (kind == "cyclic") {
    description.kind = Kind::kCyclic;
    reader.Known({"kind", "order", "axis"});
  } else if (kind == "dihedral") {
    description.kind = Kind::kDihedral;
    description.half_turn_axis = reader.Vector("half_turn_axis");
    reader.Known({"kind", "order", "axis", "half_turn_axis"});
  } else if (kind == "continuous") {
    description.kind = Kind::kContinuous;
    description.flips = reader.Bool("flips");
    reader.Known({"kind", "axis", "flips"});
  } else {
    reader.Fail("kind", "none, cyclic, dihedral, continuous or finite");
  }
  if (kind != "none") description.axis = reader.Vector("axis");
  if (kind == "cyclic" || kind == "dihedral") {
    description.order = static_cast<int>(reader.Integer("order", 1, 1000));
  }
  if (reader.error()) return *reader.error();
  Result<SymmetryGroup> group = MakeSymmetry(description);
  if (!group) return Error{group.error().code, place + ": " + group.error().message};
  return group;
}

}  // namespace

std::string WriteModelToml(const ModelDescription& description) {
  std::string text = "# Written by vantage-model.\n";
  text += "id = " + Quoted(description.id) + "\n";
  text += "source = " + Quoted(description.source) + "\n";
  text += "unit = \"m\"\n";
  text += "diameter_m = " + Number(description.diameter) + "\n";
  text += "center_m = " + Numbers(description.center) + "\n";
  text += Format("mesh_hash = \"%016jx\"\n", uintmax_t{description.mesh_hash});
  text += "num_samples = " + std::to_string(description.num_samples) + "\n";
  text += "\n[symmetry]\n" + SymmetryTable(description.symmetry);
  return text;
}

Result<ModelDescription> ReadModelToml(const std::string& text, const std::filesystem::path& file) {
  toml::table table;
  try {
    table = toml::parse(text, std::string_view(file.native()));
  } catch (const toml::parse_error& error) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s:%u:%u: %s, expected TOML",
                        file.c_str(),
                        error.source().begin.line,
                        error.source().begin.column,
                        std::string(error.description()).c_str())};
  }
  TableReader reader(table, file.native());
  reader.Known(
      {"id", "source", "unit", "diameter_m", "center_m", "mesh_hash", "num_samples", "symmetry"});
  ModelDescription description;
  description.id = reader.String("id");
  description.source = reader.String("source");
  if (reader.String("unit") != "m") reader.Fail("unit", "\"m\"");
  description.diameter = reader.Positive("diameter_m");
  description.center = reader.Vector("center_m");
  const std::string hash = reader.String("mesh_hash");
  const auto [end, error] =
      std::from_chars(hash.data(), hash.data() + hash.size(), description.mesh_hash, 16);
  if (error != std::errc() || end != hash.data() + hash.size()) {
    reader.Fail("mesh_hash", "16 hexadecimal digits");
  }
  description.num_samples = static_cast<size_t>(reader.Integer("num_samples", 1, kMostSamples));
  const toml::table* symmetry = table["symmetry"].as_table();
  if (symmetry == nullptr) reader.Fail("symmetry", "a table [symmetry]");
  if (reader.error()) return *reader.error();
  Result<SymmetryGroup> group = ReadSymmetry(*symmetry, file.native() + ": [symmetry]");
  if (!group) return group.error();
  description.symmetry = std::move(group).value();
  return description;
}

}  // namespace vantage
