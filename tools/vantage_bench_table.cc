// vantage-bench-table: turns what a Google Benchmark program measured into the project's table and
// JSON: medians, bars, peers of the same run.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "common/format.h"
#include "common/result.h"
#include "nodes/command_line.h"

namespace vantage {
namespace {

using nlohmann::json;

/// One line of bars.csv: part, benchmark, bar, peer. A bar is an upper bound in the benchmark's own
/// time unit; empty fields mean none.
struct Bar {
  std::optional<double> bar;
  std::string peer;
};

struct Measured {
  std::string name;
  double value = 0.0;
  std::string unit;
  json accuracy;
};

Result<std::map<std::string, Bar>> ReadBars(const std::string& file, const std::string& part) {
  std::ifstream stream(file);
  if (!stream) return Error{ErrorCode::kNotFound, "bars " + file + " can't be read"};
  std::map<std::string, Bar> bars;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> fields;
    std::istringstream columns(line + ",");
    for (std::string field; std::getline(columns, field, ',');) fields.push_back(field);
    if (fields.size() != 4) {
      return Error{ErrorCode::kCorrupt,
                   Format("%s:%d: expected part,benchmark,bar,peer", file.c_str(), number)};
    }
    if (fields[0] != part) continue;
    Bar bar;
    bar.peer = fields[3];
    if (!fields[2].empty()) {
      char* end = nullptr;
      bar.bar = std::strtod(fields[2].c_str(), &end);
      if (*end != '\0' || *bar.bar <= 0.0) {
        return Error{ErrorCode::kCorrupt,
                     Format("%s:%d: bar \"%s\", expected a positive number",
                            file.c_str(),
                            number,
                            fields[2].c_str())};
      }
    }
    bars[fields[1]] = bar;
  }
  return bars;
}

Result<json> ReadJson(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) return Error{ErrorCode::kNotFound, "measurements " + file + " can't be read"};
  json document = json::parse(stream, nullptr, false);
  if (document.is_discarded() || !document.contains("benchmarks")) {
    return Error{ErrorCode::kCorrupt, file + " is no output of Google Benchmark"};
  }
  return document;
}

std::vector<Measured> Medians(const json& document) {
  static const std::vector<std::string> kOwnKeys = {"family_index",
                                                    "per_family_instance_index",
                                                    "repetitions",
                                                    "repetition_index",
                                                    "threads",
                                                    "iterations",
                                                    "real_time",
                                                    "cpu_time",
                                                    "items_per_second",
                                                    "bytes_per_second"};
  std::vector<Measured> rows;
  for (const json& entry : document["benchmarks"]) {
    if (entry.value("aggregate_name", "") != "median") continue;
    Measured row;
    row.name = entry.value("run_name", "");
    row.value = entry.value("cpu_time", 0.0);
    row.unit = entry.value("time_unit", "ns");
    row.accuracy = json::object();
    for (const auto& [key, value] : entry.items()) {
      const bool own = std::find(kOwnKeys.begin(), kOwnKeys.end(), key) != kOwnKeys.end();
      if (value.is_number() && !own) row.accuracy[key] = value;
    }
    rows.push_back(row);
  }
  return rows;
}

json MakeRow(const Measured& measured, const Bar& bar, const std::vector<Measured>& all) {
  json row = {{"name", measured.name},
              {"value", measured.value},
              {"unit", measured.unit},
              {"bar", nullptr},
              {"met", nullptr},
              {"peer", nullptr},
              {"peer_value", nullptr},
              {"ratio", nullptr},
              {"accuracy", measured.accuracy}};
  if (bar.bar) {
    row["bar"] = *bar.bar;
    row["met"] = measured.value <= *bar.bar;
  }
  for (const Measured& peer : all) {
    if (bar.peer.empty() || peer.name != bar.peer || peer.unit != measured.unit) continue;
    row["peer"] = peer.name;
    row["peer_value"] = peer.value;
    row["ratio"] = peer.value / measured.value;
  }
  return row;
}

void PrintTable(const json& rows) {
  std::printf("%-52s %12s %-3s %10s %5s %10s  %s\n",
              "benchmark",
              "median",
              "",
              "bar",
              "met",
              "ratio",
              "accuracy and peer");
  for (const json& row : rows) {
    std::string notes = row["peer"].is_null() ? "" : "vs " + row["peer"].get<std::string>();
    for (const auto& [key, value] : row["accuracy"].items()) {
      notes += Format("%s%s %.4g", notes.empty() ? "" : ", ", key.c_str(), value.get<double>());
    }
    const std::string bar = row["bar"].is_null() ? "" : Format("%.4g", row["bar"].get<double>());
    const std::string met = row["met"].is_null() ? "" : (row["met"].get<bool>() ? "yes" : "NO");
    const std::string ratio =
        row["ratio"].is_null() ? "" : Format("%.2f", row["ratio"].get<double>());
    std::printf("%-52s %12.4g %-3s %10s %5s %10s  %s\n",
                row["name"].get<std::string>().c_str(),
                row["value"].get<double>(),
                row["unit"].get<std::string>().c_str(),
                bar.c_str(),
                met.c_str(),
                ratio.c_str(),
                notes.c_str());
  }
}

struct Options {
  std::string raw;
  std::string bars;
  std::string part;
  std::string commit;
  std::string output;
  bool check = false;
};

Result<bool> Run(const Options& options) {
  const Result<std::map<std::string, Bar>> bars = ReadBars(options.bars, options.part);
  if (!bars) return bars.error();
  const Result<json> document = ReadJson(options.raw);
  if (!document) return document.error();
  const std::vector<Measured> measured = Medians(*document);
  json rows = json::array();
  bool all_met = true;
  for (const Measured& each : measured) {
    const auto found = bars->find(each.name);
    const json row = MakeRow(each, found == bars->end() ? Bar{} : found->second, measured);
    if (row["met"].is_boolean() && !row["met"].get<bool>()) all_met = false;
    rows.push_back(row);
  }
  for (const auto& [name, bar] : *bars) {
    const bool present = std::any_of(
        measured.begin(), measured.end(), [&](const Measured& each) { return each.name == name; });
    if (!present) {
      return Error{ErrorCode::kNotFound,
                   options.bars + " names the benchmark " + name + ", which did not run"};
    }
  }
  PrintTable(rows);
  const json& context = document->at("context");
  const json result = {{"machine",
                        {{"num_cpus", context.value("num_cpus", 0)},
                         {"mhz_per_cpu", context.value("mhz_per_cpu", 0)}}},
                       {"commit", options.commit},
                       {"rows", rows}};
  std::ofstream stream(options.output);
  stream << result.dump(1) << '\n';
  if (!stream) return Error{ErrorCode::kIo, options.output + " can't be written"};
  return all_met;
}

// The file's structure is Google Benchmark's or it is refused: values of other types throw.
Result<bool> RunChecked(const Options& options) {
  try {
    return Run(options);
  } catch (const json::exception& exception) {
    return Error{ErrorCode::kCorrupt,
                 options.raw + " is no output of Google Benchmark: " + exception.what()};
  }
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Options options;
  CLI::App app("Table and JSON of a benchmark's medians, with bars and peers",
               "vantage-bench-table");
  app.add_option("measurements", options.raw, "JSON of Google Benchmark")->required();
  app.add_option("--bars", options.bars, "CSV of part,benchmark,bar,peer")->required();
  app.add_option("--part", options.part, "which part's bars count")->required();
  app.add_option("--commit", options.commit, "what was measured");
  app.add_option("--output", options.output, "JSON to write")->required();
  app.add_flag("--check", options.check, "exit 1 when a bar is not met");
  if (const std::optional<int> code = vantage::ParseCommandLine(app, argc, argv)) return *code;
  const vantage::Result<bool> met = vantage::RunChecked(options);
  if (!met) {
    std::fprintf(stderr, "vantage-bench-table: %s\n", met.error().message.c_str());
    return 2;
  }
  return options.check && !*met ? 1 : 0;
}
