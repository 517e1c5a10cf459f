// docs/config.md against the readers: what it lists is read, with the default and the range that it
// tells, and what is read is listed.
#include <gtest/gtest.h>
#include <toml++/toml.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "common/format.h"
#include "nodes/camera_calibration.h"
#include "nodes/config_reader.h"
#include "nodes/extrinsics_config.h"
#include "nodes/fusion_config.h"
#include "nodes/openni2_config.h"
#include "nodes/ppf_config.h"
#include "nodes/process.h"
#include "nodes/shot_config.h"
#include "nodes/sim_config.h"
#include "nodes/up_config.h"
#include "nodes/v4l2_config.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = VANTAGE_SOURCE_DIR;

// ---- The document ----

struct DocKey {
  std::string name;
  bool chosen = false;       // The name is the user's to choose.
  std::string default_text;  // A TOML value, "required", or words.
  bool literal = false;      // default_text is a TOML value.
  std::string range;
};

struct DocTable {
  std::string heading;               // "[sim.arm]", "[[sim.object]]", or words
  std::vector<std::string> path;     // {"sim", "arm"}; empty for the calibration file
  std::vector<std::string> readers;  // "vantage-ppf", ...
  std::vector<DocKey> keys;
};

struct Document {
  std::vector<DocTable> tables;
  std::vector<std::string> examples;  // The texts of its ```toml blocks.
};

std::string Unquoted(const std::string& cell) {
  const bool quoted = cell.size() > 1 && cell.front() == '`' && cell.back() == '`';
  return quoted ? cell.substr(1, cell.size() - 2) : cell;
}

std::vector<std::string> Cells(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line.substr(1));
  for (std::string cell; std::getline(stream, cell, '|');) {
    const size_t begin = cell.find_first_not_of(' ');
    const size_t end = cell.find_last_not_of(' ');
    cells.push_back(begin == std::string::npos ? "" : cell.substr(begin, end - begin + 1));
  }
  return cells;
}

std::vector<std::string> PathOf(const std::string& heading) {
  std::vector<std::string> path;
  std::string inner;
  std::ranges::copy_if(
      heading, std::back_inserter(inner), [](char c) { return c != '[' && c != ']'; });
  std::istringstream stream(inner);
  for (std::string part; std::getline(stream, part, '.');) {
    path.push_back(part == "<NAME>" ? "XTION" : part);
  }
  return path;
}

DocTable StartTable(const std::string& heading) {
  DocTable table;
  table.heading = heading;
  if (heading.starts_with("[")) table.path = PathOf(heading.substr(0, heading.rfind(']')));
  return table;
}

void ReadRow(const std::string& line, DocTable* table) {
  const std::vector<std::string> cells = Cells(line);
  ASSERT_EQ(cells.size(), 4U) << line;
  if (cells[0] == "key" || cells[0].starts_with("---")) return;
  ASSERT_NE(cells[0], Unquoted(cells[0])) << "key without backticks: " << line;
  EXPECT_FALSE(cells[3].empty()) << line;
  DocKey key;
  key.name = Unquoted(cells[0]);
  key.chosen = key.name == "<MODEL>";
  if (key.chosen) key.name = "mug";
  key.default_text = Unquoted(cells[1]);
  key.literal = key.default_text != cells[1];
  key.range = cells[2];
  table->keys.push_back(key);
}

Document ReadDocument() {
  Document document;
  std::ifstream file(kSource / "docs/config.md");
  bool in_example = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("```")) {
      in_example = line == "```toml";
      if (in_example) document.examples.emplace_back();
    } else if (in_example) {
      document.examples.back() += line + "\n";
    } else if (line.starts_with("## ")) {
      document.tables.push_back(StartTable(line.substr(3)));
    } else if (line.starts_with("Read by ")) {
      const std::regex program("every process|vantage-[a-z0-9-]+");
      const std::string owners = line.substr(0, line.find(';'));
      for (std::sregex_iterator found(owners.begin(), owners.end(), program), end; found != end;
           ++found) {
        document.tables.back().readers.push_back(found->str());
      }
    } else if (line.starts_with("|")) {
      ReadRow(line, &document.tables.back());
    }
  }
  for (DocTable& table : document.tables) {
    if (table.path.empty()) table.readers = {"calibration"};
  }
  return document;
}

// ---- The readers ----

// What a reader says to a file: its complaint, or nothing, and the values in effect.
struct Outcome {
  std::string error;
  std::string effective;
};

Outcome Finish(ConfigReader& config) {
  IgnoreTablesOfOthers(config);
  const Result<void> finished = config.Finish();
  return {finished ? "" : finished.error().message, config.Effective()};
}

template <class T>
Outcome Finish(ConfigReader& config, const Result<T>& read) {
  // The file's own errors first, as processes do.
  const Outcome outcome = Finish(config);
  return read || !outcome.error.empty() ? outcome : Outcome{read.error().message, ""};
}

using ReadConfig = std::function<Outcome(ConfigReader& config)>;

const std::map<std::string, ReadConfig>& Readers() {
  static const std::map<std::string, ReadConfig> readers = {
      {"every process",
       [](ConfigReader& config) {
         ReadBusOptions(config);
         return Finish(config);
       }},
      {"vantage-openni2",
       [](ConfigReader& config) { return Finish(config, ReadOpenni2Config(config, "openni2")); }},
      {"vantage-v4l2",
       [](ConfigReader& config) { return Finish(config, ReadV4l2Config(config, "v4l2")); }},
      {"vantage-ppf", [](ConfigReader& config) { return Finish(config, ReadPpfConfig(config)); }},
      {"vantage-shot", [](ConfigReader& config) { return Finish(config, ReadShotConfig(config)); }},
      {"vantage-fusion",
       [](ConfigReader& config) { return Finish(config, ReadFusionConfig(config)); }},
      {"vantage-extrinsics",
       [](ConfigReader& config) { return Finish(config, ReadExtrinsicsConfig(config)); }},
      {"vantage-handeye",
       [](ConfigReader& config) { return Finish(config, ReadExtrinsicsConfig(config)); }},
      {"vantage-sim-arm",
       [](ConfigReader& config) { return Finish(config, LoadSimConfig(config)); }},
      {"vantage-up",
       [](ConfigReader& config) {
         ReadUpConfig(config);
         return Finish(config);
       }},
  };
  return readers;
}

class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text) { std::ofstream(path_) << text; }
  ~TemporaryFile() { fs::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_ = fs::path(testing::TempDir()) / Format("config_doc_test.%d.toml", getpid());
};

// The example's camera, where it has the default driver, as one of V4L2's.
toml::table WithV4l2(toml::table file) {
  toml::table& camera = *file["camera"]["XTION"].as_table();
  if (camera["driver"].value_or(std::string("openni2")) == "openni2") {
    camera.insert_or_assign("driver", "v4l2");
  }
  return file;
}

Outcome ReadBy(const std::string& reader, const toml::table& file) {
  std::ostringstream text;
  text << (reader == "vantage-v4l2" ? WithV4l2(file) : file);
  if (reader == "calibration") {
    const TemporaryFile temporary(text.str());
    const Result<CameraCalibration> read = LoadCameraCalibration(temporary.path());
    return {read ? "" : read.error().message, ""};
  }
  Result<ConfigReader> config = ConfigReader::Parse(text.str(), "x.toml");
  if (!config) return {config.error().message, ""};
  const auto found = Readers().find(reader);
  if (found == Readers().end()) return {"no such reader: " + reader, ""};
  return found->second(*config);
}

// ---- Files made of the document's examples ----

toml::table Base(const Document& document, const DocTable& table) {
  if (table.path.empty()) return toml::parse(document.examples.at(2));
  toml::table base =
      toml::parse(document.examples.at(0) + document.examples.at(1) + document.examples.at(3) +
                  document.examples.at(5) + document.examples.at(6) + document.examples.at(7));
  base["models"].as_table()->insert_or_assign("folder", (kSource / "models").string());
  return base;
}

// The table at a path; made where there is none. Of an array of tables the first.
toml::table& At(toml::table& root, const std::vector<std::string>& path) {
  toml::table* at = &root;
  for (const std::string& part : path) {
    if (!at->contains(part)) at->insert(part, toml::table());
    toml::node* node = at->get(part);
    at = node->is_array() ? node->as_array()->get(0)->as_table() : node->as_table();
  }
  return *at;
}

void Set(const std::string& key, const std::string& literal, toml::table* table) {
  const toml::table value = toml::parse("value = " + literal);
  table->insert_or_assign(key, *value.get("value"));
}

bool SameValue(const toml::node& a, const toml::node& b) {
  if (a.is_array() && b.is_array()) {
    const toml::array& left = *a.as_array();
    const toml::array& right = *b.as_array();
    if (left.size() != right.size()) return false;
    for (size_t i = 0; i < left.size(); ++i) {
      if (!SameValue(*left.get(i), *right.get(i))) return false;
    }
    return true;
  }
  if (a.is_number() && b.is_number()) {
    const double left = *a.value<double>();
    const double right = *b.value<double>();
    return std::abs(left - right) <= 1e-7 * std::abs(right);
  }
  if (a.is_string() && b.is_string()) return a.as_string()->get() == b.as_string()->get();
  return a.is_boolean() && b.is_boolean() && a.as_boolean()->get() == b.as_boolean()->get();
}

bool SameValue(const std::string& a, const std::string& b) {
  const toml::table both = toml::parse("a = " + a + "\nb = " + b);
  return SameValue(*both.get("a"), *both.get("b"));
}

// The value in effect of a key, as text.
std::optional<std::string> EffectiveValue(const std::string& effective,
                                          const DocTable& table,
                                          const std::string& key) {
  std::string start;
  for (const std::string& part : table.path) {
    const bool is_list =
        part == "object" || part == "likely_pose" || part == "keep_out" || part == "process";
    start += part + (is_list ? "[0]." : ".");
  }
  start += key + " = ";
  std::istringstream lines(effective);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(start)) return line.substr(start.size());
  }
  return std::nullopt;
}

// ---- A value out of the range that the document tells, and what must be said of it ----

struct Probe {
  std::string literal;
  std::string expected;  // A regular expression.
};

std::string NumberPattern(const std::string& documented) {
  // However it is written: the message's number is compared by its value.
  return Format("%.17g", std::stod(documented));
}

std::optional<Probe> NumberProbe(const std::string& range) {
  const std::regex form("(?:(\\d) numbers, )?(\\S+) to ([^, ]+)(, whole)?");
  std::smatch parts;
  if (!std::regex_match(range, parts, form)) return std::nullopt;
  const double below = std::stod(parts[2]) - 1.0;
  const std::string number = Format(parts[4].matched ? "%.0f" : "%.1f", below);
  Probe probe;
  probe.expected = NumberPattern(parts[2]) + " to " + NumberPattern(parts[3]);
  if (parts[4].matched) probe.expected += ", whole";
  if (!parts[1].matched) {
    probe.literal = number;
    return probe;
  }
  probe.expected = parts[1].str() + " numbers, " + probe.expected;
  for (int i = 0; i < std::stoi(parts[1]); ++i) probe.literal += (i == 0 ? "[" : ", ") + number;
  probe.literal += "]";
  return probe;
}

// A complaint of ConfigReader about a number, in the document's form.
std::string AsDocumented(const std::string& error) {
  const std::regex form(
      "expected (?:a list of (\\d) numbers|a number) from (\\S+) to ([^, ]+)(, whole)?$");
  std::smatch parts;
  if (!std::regex_search(error, parts, form)) return error;
  return (parts[1].matched ? parts[1].str() + " numbers, " : "") + NumberPattern(parts[2]) +
         " to " + NumberPattern(parts[3]) + parts[4].str();
}

Probe MakeProbe(const std::string& range) {
  if (const std::optional<Probe> number = NumberProbe(range)) return *number;
  if (range == "true or false") return {"1", "expected true or false"};
  if (range == "list of texts") return {"1", "expected a list of texts in quotes"};
  if (range == "text" || range == "path") return {"1", "expected a text in quotes"};
  Probe choice{"\"no such choice\"", "expected one of"};
  const std::regex name("`([^`]+)`");
  for (std::sregex_iterator found(range.begin(), range.end(), name), end; found != end; ++found) {
    choice.expected += " \"" + (*found)[1].str() + "\"";
  }
  return choice;
}

// ---- Tests ----

class ConfigDocument : public testing::Test {
 protected:
  const Document document_ = ReadDocument();
};

TEST_F(ConfigDocument, HasTablesWithReadersAndExamples) {
  ASSERT_EQ(document_.examples.size(), 8U);
  EXPECT_GT(document_.tables.size(), 10U);
  for (const DocTable& table : document_.tables) {
    EXPECT_FALSE(table.readers.empty()) << table.heading << " has no line \"Read by\"";
    EXPECT_FALSE(table.keys.empty()) << table.heading;
    std::set<std::string> names;
    for (const DocKey& key : table.keys) {
      EXPECT_TRUE(names.insert(key.name).second) << table.heading << " lists twice: " << key.name;
    }
  }
}

TEST_F(ConfigDocument, ItsExamplesAreAccepted) {
  for (const DocTable& table : document_.tables) {
    for (const std::string& reader : table.readers) {
      EXPECT_EQ(ReadBy(reader, Base(document_, table)).error, "") << reader;
    }
  }
  toml::table file = Base(document_, document_.tables.front());
  const toml::table tables = toml::parse(document_.examples.at(4));
  file.insert("confusion", *tables.get("confusion"));
  EXPECT_EQ(ReadBy("vantage-fusion", file).error, "");
}

TEST_F(ConfigDocument, TheDefaultsThatItListsAreAccepted) {
  for (const DocTable& table : document_.tables) {
    toml::table file = Base(document_, table);
    toml::table& at = At(file, table.path);
    for (const DocKey& key : table.keys) {
      if (key.literal) Set(key.name, key.default_text, &at);
    }
    for (const std::string& reader : table.readers) {
      EXPECT_EQ(ReadBy(reader, file).error, "") << table.heading << " by " << reader;
    }
  }
}

TEST_F(ConfigDocument, TheDefaultsThatItListsAreThoseInEffect) {
  for (const DocTable& table : document_.tables) {
    if (table.path.empty()) continue;  // A calibration is no configuration of a process.
    toml::table file = Base(document_, table);
    At(file, table.path);
    for (const std::string& reader : table.readers) {
      const std::string effective = ReadBy(reader, file).effective;
      for (const DocKey& key : table.keys) {
        // By its driver the table belongs to a process; it is not by default V4L2's.
        if (key.chosen || (key.name == "driver" && reader == "vantage-v4l2")) continue;
        const std::optional<std::string> value = EffectiveValue(effective, table, key.name);
        ASSERT_TRUE(value.has_value()) << table.heading << " " << key.name << " by " << reader;
        if (key.literal) {
          EXPECT_TRUE(SameValue(*value, key.default_text))
              << table.heading << " " << key.name << " is " << *value << " by default in " << reader
              << ", " << key.default_text << " in docs/config.md";
        } else if (key.default_text == "none") {
          EXPECT_TRUE(*value == "[]" || *value == "''" || *value == "\"\"" || *value == "none")
              << table.heading << " " << key.name << " is " << *value << " by default in "
              << reader;
        }
      }
    }
  }
}

TEST_F(ConfigDocument, RequiredKeysAreRequired) {
  for (const DocTable& table : document_.tables) {
    for (const DocKey& key : table.keys) {
      if (key.default_text != "required") continue;
      toml::table file = Base(document_, table);
      ASSERT_TRUE(At(file, table.path).erase(key.name)) << table.heading << " " << key.name;
      const bool refused = std::ranges::any_of(table.readers, [&](const std::string& reader) {
        return ReadBy(reader, file).error.find(key.name + ": missing") != std::string::npos;
      });
      EXPECT_TRUE(refused) << table.heading << " " << key.name;
    }
  }
}

TEST_F(ConfigDocument, OutOfTheRangeThatItTellsIsRefusedWithThatRange) {
  for (const DocTable& table : document_.tables) {
    for (const DocKey& key : table.keys) {
      const Probe probe = MakeProbe(key.range);
      toml::table file = Base(document_, table);
      Set(key.name, probe.literal, &At(file, table.path));
      for (const std::string& reader : table.readers) {
        const std::string error = AsDocumented(ReadBy(reader, file).error);
        EXPECT_TRUE(error.ends_with(probe.expected))
            << table.heading << " " << key.name << " = " << probe.literal << " by " << reader
            << ": docs/config.md tells the range " << key.range << ", the message: " << error;
      }
    }
  }
}

std::set<std::string> KnownHere(const std::string& error) {
  const std::string before = "unknown key; known here: ";
  const size_t at = error.find(before);
  if (at == std::string::npos) return {error};
  std::set<std::string> known;
  std::istringstream stream(error.substr(at + before.size()));
  for (std::string name; std::getline(stream, name, ',');) {
    known.insert(name.substr(name.front() == ' ' ? 1 : 0));
  }
  return known;
}

// The keys of a table, which may be listed in several parts, and of the tables below it that the
// reader reads.
std::set<std::string> ListedFor(const std::string& reader,
                                const std::vector<std::string>& path,
                                const Document& document) {
  std::set<std::string> listed;
  for (const DocTable& table : document.tables) {
    if (std::ranges::find(table.readers, reader) == table.readers.end()) continue;
    if (table.path == path) {
      for (const DocKey& key : table.keys) listed.insert(key.name);
    }
    if (path.empty() || table.path.size() != path.size() + 1) continue;
    if (std::equal(path.begin(), path.end(), table.path.begin())) listed.insert(table.path.back());
  }
  return listed;
}

TEST_F(ConfigDocument, EveryKeyThatIsReadIsListed) {
  for (const DocTable& table : document_.tables) {
    if (table.keys.front().chosen) continue;  // Whatever key is read.
    toml::table file = Base(document_, table);
    Set("no_such_key", "1", &At(file, table.path));
    for (const std::string& reader : table.readers) {
      EXPECT_EQ(KnownHere(ReadBy(reader, file).error), ListedFor(reader, table.path, document_))
          << table.heading << " " << reader;
    }
  }
}

TEST_F(ConfigDocument, EveryTableThatIsReadIsListed) {
  std::set<std::string> listed;
  for (const DocTable& table : document_.tables) {
    if (!table.path.empty()) listed.insert(table.path.front());
  }
  for (const auto& [name, read] : Readers()) {
    toml::table file = Base(document_, document_.tables.front());
    file.insert("no_such_table", toml::table());
    EXPECT_EQ(KnownHere(ReadBy(name, file).error), listed) << name;
  }
}

// What readers say to a file as it is, or with the bundled models for those that a user has yet to
// make, under out/.
std::map<std::string, std::string> ErrorsOf(const fs::path& file) {
  const toml::table content = toml::parse_file(file.string());
  const std::string folder = content["models"]["folder"].value_or(std::string());
  const bool made_later = folder.starts_with("../out/");
  std::set<std::string> readers = {"every process", "vantage-ppf"};
  if (!made_later) readers.insert("vantage-fusion");
  if (content["sim"].is_table()) readers.insert("vantage-sim-arm");
  if (content["extrinsics"].is_table()) readers.insert("vantage-extrinsics");
  for (const auto& [name, camera] : *content["camera"].as_table()) {
    const std::string driver = (*camera.as_table())["driver"].value_or(std::string("openni2"));
    if (camera.as_table()->contains("device")) readers.insert("vantage-" + driver);
  }
  std::map<std::string, std::string> errors;
  for (const std::string& reader : readers) {
    Result<ConfigReader> config = ConfigReader::Open(file);
    errors[reader] = config ? Readers().at(reader)(*config).error : config.error().message;
  }
  if (made_later) {
    toml::table bundled = content;
    bundled["models"].as_table()->insert_or_assign("folder", (kSource / "models").string());
    bundled["models"].as_table()->insert_or_assign("use", toml::array{"mug"});
    errors["vantage-fusion"] = ReadBy("vantage-fusion", bundled).error;
  }
  return errors;
}

TEST(BundledConfigs, AreAcceptedByTheProcessesThatUseThem) {
  int num_files = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(kSource / "config")) {
    if (entry.path().extension() != ".toml") continue;
    ++num_files;
    for (const auto& [reader, error] : ErrorsOf(entry.path())) EXPECT_EQ(error, "") << reader;
  }
  EXPECT_GE(num_files, 2);
}

}  // namespace
}  // namespace vantage
