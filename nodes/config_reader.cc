#include "nodes/config_reader.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <sstream>

#include "common/format.h"

namespace vantage {

namespace {

// Values as they would stand in a file.
std::string TextOf(const toml::node& node) {
  if (const auto* number = node.as_floating_point()) return Format("%.15g", number->get());
  if (const auto* list = node.as_array()) {
    std::string text;
    for (const toml::node& each : *list) text += (text.empty() ? "" : ", ") + TextOf(each);
    return "[" + text + "]";
  }
  std::ostringstream stream;
  node.visit([&stream](const auto& value) { stream << value; });
  return stream.str();
}
std::string TextOf(double value) { return Format("%.10g", value); }
std::string TextOf(bool value) { return value ? "true" : "false"; }
std::string TextOf(int64_t value) { return std::to_string(value); }
std::string TextOf(int value) { return std::to_string(value); }
std::string TextOf(const std::string& value) { return TextOf(toml::value<std::string>(value)); }

std::string TextOf(const std::optional<double>& value) { return value ? TextOf(*value) : "none"; }

template <class T>
std::string TextOf(const std::vector<T>& values) {
  std::string text;
  for (const T& value : values) text += (text.empty() ? "" : ", ") + TextOf(value);
  return "[" + text + "]";
}

// Letters to insert, remove or replace, with neighbors that changed places as one.
size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<std::vector<size_t>> least(a.size() + 1, std::vector<size_t>(b.size() + 1));
  for (size_t i = 0; i <= a.size(); ++i) {
    for (size_t k = 0; k <= b.size(); ++k) {
      if (i == 0 || k == 0) {
        least[i][k] = i + k;
        continue;
      }
      const size_t replaced = least[i - 1][k - 1] + (a[i - 1] == b[k - 1] ? 0 : 1);
      least[i][k] = std::min({least[i - 1][k] + 1, least[i][k - 1] + 1, replaced});
      if (i > 1 && k > 1 && a[i - 1] == b[k - 2] && a[i - 2] == b[k - 1]) {
        least[i][k] = std::min(least[i][k], least[i - 2][k - 2] + 1);
      }
    }
  }
  return least[a.size()][b.size()];
}

// The name that was probably meant; empty where none is near.
std::string NearestName(const std::string& name, const std::set<std::string, std::less<>>& names) {
  constexpr size_t kLongest = 100;
  if (name.size() > kLongest) return "";
  std::string nearest;
  size_t least = std::min(name.size() / 3 + 1, name.size() - 1);
  for (const std::string& each : names) {
    if (each.size() > name.size() + least) continue;
    if (const size_t distance = EditDistance(name, each); distance <= least) {
      if (distance == least && !nearest.empty()) continue;
      least = distance;
      nearest = each;
    }
  }
  return nearest;
}

}  // namespace

struct ConfigReader::Document {
  std::string name;
  std::filesystem::path folder;
  std::string text;
  toml::table root;
  std::optional<std::string> first_error;
  std::optional<std::string> first_missing;  // Told last: a misspelt key is the cause of it.
  std::shared_ptr<Table::Node> root_node;
};

// One table of the file and which of its keys were asked for. A table that is absent has no toml.
struct ConfigReader::Table::Node {
  std::weak_ptr<Document> document;
  const toml::table* toml = nullptr;
  std::string path;  // "" or "fusion." or "sim.object[1]."
  std::set<std::string, std::less<>> asked;
  std::map<std::string, std::string> defaults;  // As they would stand in a file.
  std::map<std::string, std::vector<std::shared_ptr<Node>>> children;
  bool ignored = false;

  void Fail(const std::string& key, const toml::node* at, const std::string& expectation) const {
    const std::shared_ptr<Document> owner = document.lock();
    if (!owner || owner->first_error) return;
    owner->first_error = Sentence(key, at, expectation);
  }

  [[nodiscard]] std::string Sentence(const std::string& key,
                                     const toml::node* at,
                                     const std::string& expectation) const {
    std::string where = document.lock()->name;
    if (at != nullptr && at->source().begin.line > 0) {
      where += Format(":%u", static_cast<unsigned>(at->source().begin.line));
    }
    std::string value;
    if (at != nullptr && at->is_value()) value = " = " + TextOf(*at);
    return where + ": " + path + key + value + ": " + expectation;
  }

  const toml::node* Ask(const std::string& key) {
    asked.insert(key);
    return toml == nullptr ? nullptr : toml->get(key);
  }

  template <class T>
  const toml::node* Ask(const std::string& key, const T& default_value) {
    defaults.emplace(key, TextOf(default_value));
    return Ask(key);
  }

  void AppendEffective(std::string* text) const {
    for (const std::string& key : asked) {
      const toml::node* node = toml == nullptr ? nullptr : toml->get(key);
      const auto tables = children.find(key);
      if (tables != children.end()) {
        for (const std::shared_ptr<Node>& child : tables->second) child->AppendEffective(text);
      } else if (node != nullptr) {
        *text += path + key + " = " + TextOf(*node) + "\n";
      } else if (const auto found = defaults.find(key); found != defaults.end()) {
        *text += path + key + " = " + found->second + "\n";
      }
    }
  }

  void ReportUnasked() const {
    if (toml == nullptr || ignored) return;
    for (const auto& [key, value] : *toml) {
      const std::string name(key.str());
      if (!asked.contains(name)) {
        std::string known;
        for (const std::string& each : asked) known += (known.empty() ? "" : ", ") + each;
        const std::string meant = NearestName(name, asked);
        const std::string hint = meant.empty() ? "" : "; did you mean " + meant + "?";
        Fail(name, &value, "unknown key; known here: " + known + hint);
        return;
      }
      const auto found = children.find(name);
      if (found == children.end()) continue;
      for (const std::shared_ptr<Node>& child : found->second) child->ReportUnasked();
    }
  }
};

namespace {

constexpr std::uintmax_t kLargestFile = 1U << 20U;

template <class Number>
std::string Range(Number lowest, Number highest) {
  std::ostringstream stream;
  stream << "expected a number from " << lowest << " to " << highest;
  return stream.str();
}

template <class Integer>
std::optional<Integer> IntegerIn(const toml::node& node, Integer lowest, Integer highest) {
  if (!node.is_integer()) return std::nullopt;
  const int64_t value = node.as_integer()->get();
  if (value < static_cast<int64_t>(lowest) || value > static_cast<int64_t>(highest)) {
    return std::nullopt;
  }
  return static_cast<Integer>(value);
}

std::optional<double> NumberIn(const toml::node& node, double lowest, double highest) {
  const std::optional<double> value = node.value<double>();
  if (!node.is_number() || !value || !std::isfinite(*value) || *value < lowest ||
      *value > highest) {
    return std::nullopt;
  }
  return value;
}

}  // namespace

void ConfigReader::Table::Read(const std::string& key,
                               double* value,
                               double lowest,
                               double highest) {
  const toml::node* node = node_->Ask(key, *value);
  if (node == nullptr) return;
  const std::optional<double> number = NumberIn(*node, lowest, highest);
  if (!number) return node_->Fail(key, node, Range(lowest, highest));
  *value = *number;
}

void ConfigReader::Table::Read(const std::string& key, int* value, int lowest, int highest) {
  const toml::node* node = node_->Ask(key, *value);
  if (node == nullptr) return;
  const std::optional<int> number = IntegerIn(*node, lowest, highest);
  if (!number) return node_->Fail(key, node, Range(lowest, highest) + ", whole");
  *value = *number;
}

void ConfigReader::Table::Read(const std::string& key,
                               int64_t* value,
                               int64_t lowest,
                               int64_t highest) {
  const toml::node* node = node_->Ask(key, *value);
  if (node == nullptr) return;
  const std::optional<int64_t> number = IntegerIn(*node, lowest, highest);
  if (!number) return node_->Fail(key, node, Range(lowest, highest) + ", whole");
  *value = *number;
}

void ConfigReader::Table::Read(const std::string& key,
                               std::optional<double>* value,
                               double lowest,
                               double highest) {
  const toml::node* node = node_->Ask(key, *value);
  if (node == nullptr) return;
  const std::optional<double> number = NumberIn(*node, lowest, highest);
  if (!number) return node_->Fail(key, node, Range(lowest, highest));
  *value = number;
}

void ConfigReader::Table::Read(const std::string& key, bool* value) {
  const toml::node* node = node_->Ask(key, *value);
  if (node == nullptr) return;
  if (!node->is_boolean()) return node_->Fail(key, node, "expected true or false");
  *value = node->as_boolean()->get();
}

void ConfigReader::Table::Read(const std::string& key, std::string* value) {
  const toml::node* node = node_->Ask(key, *value);
  if (node == nullptr) return;
  if (!node->is_string()) return node_->Fail(key, node, "expected a text in quotes");
  *value = node->as_string()->get();
}

void ConfigReader::Table::Read(const std::string& key, std::vector<std::string>* value) {
  const toml::node* node = node_->Ask(key, *value);
  if (node == nullptr) return;
  const char* expectation = "expected a list of texts in quotes";
  if (!node->is_array()) return node_->Fail(key, node, expectation);
  std::vector<std::string> texts;
  for (const toml::node& element : *node->as_array()) {
    if (!element.is_string()) return node_->Fail(key, &element, expectation);
    texts.push_back(element.as_string()->get());
  }
  *value = std::move(texts);
}

void ConfigReader::Table::ReadNumbers(const std::string& key,
                                      size_t size,
                                      double lowest,
                                      double highest,
                                      std::vector<double>* value) {
  const toml::node* node = node_->Ask(key, *value);
  if (node == nullptr) return;
  const std::string expectation =
      Format("expected a list of %zu numbers from %g to %g", size, lowest, highest);
  if (!node->is_array() || node->as_array()->size() != size) {
    return node_->Fail(key, node, expectation);
  }
  std::vector<double> numbers;
  for (const toml::node& element : *node->as_array()) {
    const std::optional<double> number = NumberIn(element, lowest, highest);
    if (!number) return node_->Fail(key, &element, expectation);
    numbers.push_back(*number);
  }
  *value = std::move(numbers);
}

void ConfigReader::Table::ReadChoice(const std::string& key,
                                     std::string* value,
                                     const std::vector<std::string>& allowed) {
  const toml::node* node = node_->Ask(key, *value);
  if (node == nullptr) return;
  std::string expectation = "expected one of";
  for (const std::string& choice : allowed) {
    expectation += " \"" + choice + "\"";
    if (node->is_string() && node->as_string()->get() == choice) {
      *value = choice;
      return;
    }
  }
  node_->Fail(key, node, expectation);
}

void ConfigReader::Table::ReadPose(Pose* value) {
  constexpr double kFarthest = 1000.0;  // m
  const Eigen::Vector3d start = value->translation();
  std::vector<double> position = {start.x(), start.y(), start.z()};
  std::vector<double> wxyz;
  std::vector<double> rpy;
  ReadNumbers("position_m", 3, -kFarthest, kFarthest, &position);
  ReadNumbers("quaternion_wxyz", 4, -1.0, 1.0, &wxyz);
  ReadNumbers("rpy_deg", 3, -360.0, 360.0, &rpy);
  value->translation() << position[0], position[1], position[2];
  if (!wxyz.empty() && !rpy.empty()) {
    return Fail("rpy_deg", "expected rpy_deg or quaternion_wxyz, not both");
  }
  if (!wxyz.empty()) {
    const Result<Eigen::Quaterniond> q =
        QuaternionFromWire(std::span<const double, 4>(wxyz.data(), 4));
    if (!q) return Fail("quaternion_wxyz", q.error().message);
    value->linear() = q->toRotationMatrix();
  }
  if (!rpy.empty()) {
    value->linear() = (Eigen::AngleAxisd(rpy[2] * kDegree, Eigen::Vector3d::UnitZ()) *
                       Eigen::AngleAxisd(rpy[1] * kDegree, Eigen::Vector3d::UnitY()) *
                       Eigen::AngleAxisd(rpy[0] * kDegree, Eigen::Vector3d::UnitX()))
                          .toRotationMatrix();
  }
}

void ConfigReader::Table::ReadPath(const std::string& key, std::filesystem::path* value) {
  std::string text = value->string();
  Read(key, &text);
  if (Has(key) && !text.empty()) *value = FromFolder(text);
}

std::filesystem::path ConfigReader::Table::FromFolder(const std::filesystem::path& path) const {
  return (node_->document.lock()->folder / path).lexically_normal();
}

bool ConfigReader::Table::Has(const std::string& key) const {
  return node_->toml != nullptr && node_->toml->contains(key);
}

bool ConfigReader::Table::WasAsked(const std::string& key) const {
  return node_->asked.contains(key);
}

void ConfigReader::Table::Require(const std::string& key) {
  const std::shared_ptr<Document> owner = node_->document.lock();
  if (Has(key) || owner->first_missing) return;
  owner->first_missing = node_->Sentence(key, node_->toml, "missing; it has no default");
}

ConfigReader::Table ConfigReader::Table::Sub(const std::string& key) {
  const toml::node* node = node_->Ask(key);
  std::vector<std::shared_ptr<Node>>& known = node_->children[key];
  if (known.size() == 1) return Table(known.front());
  auto child = std::make_shared<Node>();
  child->document = node_->document;
  child->path = node_->path + key + ".";
  if (node != nullptr && node->is_table()) {
    child->toml = node->as_table();
  } else if (node != nullptr) {
    node_->Fail(key, node, Format("expected a table [%s%s]", node_->path.c_str(), key.c_str()));
  }
  known = {child};
  return Table(child);
}

std::vector<ConfigReader::Table> ConfigReader::Table::SubTables(const std::string& key) {
  const toml::node* node = node_->Ask(key);
  std::vector<std::shared_ptr<Node>>& known = node_->children[key];
  if (known.empty() && node != nullptr) {
    if (!node->is_array_of_tables()) {
      node_->Fail(key, node, Format("expected tables [[%s%s]]", node_->path.c_str(), key.c_str()));
      return {};
    }
    for (const toml::node& element : *node->as_array()) {
      auto child = std::make_shared<Node>();
      child->document = node_->document;
      child->path = Format("%s%s[%zu].", node_->path.c_str(), key.c_str(), known.size());
      child->toml = element.as_table();
      known.push_back(child);
    }
  }
  std::vector<Table> tables;
  tables.reserve(known.size());
  for (const std::shared_ptr<Node>& child : known) tables.push_back(Table(child));
  return tables;
}

std::vector<std::string> ConfigReader::Table::Keys() const {
  std::vector<std::string> keys;
  if (node_->toml == nullptr) return keys;
  for (const auto& [key, value] : *node_->toml) keys.emplace_back(key.str());
  return keys;
}

void ConfigReader::Table::Fail(const std::string& key, const std::string& expectation) {
  node_->Fail(key, node_->toml == nullptr ? nullptr : node_->toml->get(key), expectation);
}

void ConfigReader::Table::IgnoreAll() { node_->ignored = true; }

Result<ConfigReader> ConfigReader::Open(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    const bool there = std::filesystem::exists(file, error);
    return Error{ErrorCode::kNotFound,
                 "config file " + file.string() + (there ? " is no file" : " is not there") +
                     "; expected a TOML file such as config/demo.toml"};
  }
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error || size > kLargestFile) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("config file %s has %ju bytes, expected at most %ju",
                        file.c_str(),
                        error ? 0 : size,
                        kLargestFile)};
  }
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) return Error{ErrorCode::kIo, "config file " + file.string() + " can't be read"};
  Result<ConfigReader> reader = Parse(text.str(), file.string());
  if (reader) reader->document_->folder = std::filesystem::absolute(file).parent_path();
  return reader;
}

Result<ConfigReader> ConfigReader::Parse(const std::string& text, const std::string& name) {
  auto document = std::make_shared<Document>();
  document->name = name;
  document->folder = std::filesystem::current_path();
  document->text = text;
  try {
    document->root = toml::parse(text);
  } catch (const toml::parse_error& error) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s:%u:%u: no valid TOML: %s",
                        name.c_str(),
                        static_cast<unsigned>(error.source().begin.line),
                        static_cast<unsigned>(error.source().begin.column),
                        std::string(error.description()).c_str())};
  }
  document->root_node = std::make_shared<Table::Node>();
  document->root_node->document = document;
  document->root_node->toml = &document->root;
  return ConfigReader(document);
}

ConfigReader::Table ConfigReader::Root() { return Table(document_->root_node); }

Result<void> ConfigReader::Finish() {
  document_->root_node->ReportUnasked();
  for (const auto& error : {document_->first_error, document_->first_missing}) {
    if (error) return Error{ErrorCode::kInvalidArgument, *error};
  }
  return {};
}

std::string ConfigReader::Effective() const {
  std::string text;
  document_->root_node->AppendEffective(&text);
  return text;
}

const std::string& ConfigReader::text() const { return document_->text; }

std::string ConfigReader::Hash() const {
  uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char byte : document_->text) {
    hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3ULL;
  }
  return Format("%016llx", static_cast<unsigned long long>(hash));
}

}  // namespace vantage
