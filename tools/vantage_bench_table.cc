// vantage-bench-table: turns what Google Benchmark programs and pose_comparison measured into the
// project's tables and JSON: medians, bars, peers of the same run.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/format.h"
#include "common/result.h"
#include "nodes/command_line.h"
#include "tools/support/bench_bars.h"
#include "tools/support/pose_records.h"
#include "tools/support/pose_summary.h"
#include "tools/support/pose_table.h"

namespace vantage {
namespace {

using nlohmann::json;

using Bars = std::map<std::string, BenchBar>;

struct Measured {
  std::string name;
  double value = 0.0;
  std::string unit;
  json accuracy;
};

Result<json> ReadJson(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) return Error{ErrorCode::kNotFound, "measurements " + file + " can't be read"};
  json document = json::parse(stream, nullptr, false);
  if (document.is_discarded() || !document.contains("benchmarks")) {
    return Error{ErrorCode::kCorrupt, file + " is no output of Google Benchmark"};
  }
  return document;
}

void AppendMedians(const json& document, std::vector<Measured>* rows) {
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
    rows->push_back(row);
  }
}

// Appends the medians. @return the context that they were measured in.
Result<json> ReadMeasurements(const std::string& file, std::vector<Measured>* rows) {
  const Result<json> document = ReadJson(file);
  if (!document) return document.error();
  try {  // Values of other types than Google Benchmark's throw.
    AppendMedians(*document, rows);
    return document->at("context");
  } catch (const json::exception& exception) {
    return Error{ErrorCode::kCorrupt,
                 file + " is no output of Google Benchmark: " + exception.what()};
  }
}

json MakeRow(const Measured& measured, const BenchBar& bar, const std::vector<Measured>& all) {
  json row = {{"name", measured.name},
              {"value", measured.value},
              {"unit", measured.unit},
              {"bar", nullptr},
              {"met", nullptr},
              {"peer", nullptr},
              {"peer_value", nullptr},
              {"ratio", nullptr},
              {"accuracy", measured.accuracy}};
  if (bar.limit) {
    row["bar"] = *bar.limit;
    row["met"] = bar.IsMetBy(measured.value);
  }
  for (const Measured& peer : all) {
    if (bar.peer.empty() || peer.name != bar.peer || peer.unit != measured.unit) continue;
    row["peer"] = peer.name;
    row["peer_value"] = peer.value;
    row["ratio"] = peer.value / measured.value;
    if (!bar.is_peers) continue;
    row["bar"] = peer.value;
    row["met"] = measured.value <= peer.value;
  }
  return row;
}

// BENCHMARK/COUNTER, what a benchmark counted beside its time.
std::optional<Measured> FindCounter(const std::vector<Measured>& measured,
                                    const std::string& name) {
  for (const Measured& each : measured) {
    if (!name.starts_with(each.name + "/")) continue;
    const auto found = each.accuracy.find(name.substr(each.name.size() + 1));
    if (found != each.accuracy.end()) {
      return Measured{name, found->get<double>(), "", json::object()};
    }
  }
  return std::nullopt;
}

// What an estimator gave over the views of a model, beside the fastest of the others.
json MakePoseRow(const PoseSummary& summary, const PoseComparison& comparison) {
  json row = {{"name", summary.estimator + "/" + summary.model},
              {"value", summary.median_ms},
              {"unit", "ms"},
              {"bar", nullptr},
              {"met", nullptr},
              {"peer", nullptr},
              {"peer_value", nullptr},
              {"ratio", nullptr},
              {"accuracy",
               {{"views", summary.views},
                {"p99_ms", summary.p99_ms},
                {"within_pct", summary.within_pct},
                {"success_pct", summary.success_pct}}}};
  if (std::isfinite(summary.median_deg)) {
    row["accuracy"]["median_deg"] = summary.median_deg;
    row["accuracy"]["median_mm"] = summary.median_mm;
  }
  for (const auto& [stage, ms] : summary.stages_ms) row["accuracy"][stage + "_ms"] = ms;
  const PoseSummary* ours = comparison.BesidePeers(summary.model, summary.estimator);
  const PoseSummary* peer = comparison.FastestPeer(summary.model);
  if (ours != nullptr && peer != nullptr) {
    row["peer"] = peer->estimator + "/" + peer->model;
    row["peer_value"] = peer->median_ms;
    row["ratio"] = peer->median_ms / ours->median_ms;
  }
  return row;
}

// A figure of whole estimators that has a bar; of every model's the worst.
json MakeFigureRow(const std::string& name,
                   const PoseComparison::Figure& figure,
                   const BenchBar& bar) {
  Measured measured{name, figure.value, figure.unit, json::object()};
  json row = MakeRow(measured, bar, {});
  row["model"] = figure.model;
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
    if (row.contains("model")) notes = "on " + row["model"].get<std::string>();
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
  std::vector<std::string> raw;
  std::vector<std::string> poses;
  std::string bars;
  std::string part;
  std::string commit;
  std::string output;
  bool check = false;
};

// A bar that is of no benchmark is of what one counted, or of a figure of whole estimators, the
// worst one of "every" model.
Result<json> MakeRows(const std::vector<Measured>& measured,
                      const PoseComparison& poses,
                      const Bars& bars,
                      const std::string& bars_file) {
  json rows = json::array();
  for (const Measured& each : measured) {
    const auto found = bars.find(each.name);
    const BenchBar bar = found == bars.end() ? BenchBar{} : found->second;
    rows.push_back(MakeRow(each, bar, measured));
    if (!bar.is_peers || !rows.back()["peer"].is_null()) continue;
    return Error{ErrorCode::kNotFound,
                 bars_file + " holds " + each.name + " against " + bar.peer +
                     ", which did not run, or in another unit"};
  }
  for (const auto& [name, bar] : bars) {
    const bool present = std::any_of(
        measured.begin(), measured.end(), [&](const Measured& each) { return each.name == name; });
    if (present) continue;
    if (const std::optional<Measured> counter = FindCounter(measured, name)) {
      rows.push_back(MakeRow(*counter, bar, {}));
      continue;
    }
    if (bar.is_optional) {
      std::printf("not measured, as its data are not there: %s\n", name.c_str());
      continue;
    }
    const Result<PoseComparison::Figure> figure = poses.Find(name);
    if (!figure) {
      return Error{ErrorCode::kNotFound,
                   bars_file + " names the benchmark " + name +
                       ", which did not run: " + figure.error().message};
    }
    rows.push_back(MakeFigureRow(name, *figure, bar));
  }
  return rows;
}

Result<void> WriteJson(const Options& options, const json& context, const json& rows) {
  const json result = {{"machine",
                        {{"num_cpus", context.value("num_cpus", 0)},
                         {"mhz_per_cpu", context.value("mhz_per_cpu", 0)}}},
                       {"commit", options.commit},
                       {"rows", rows}};
  std::ofstream stream(options.output);
  stream << result.dump(1) << '\n';
  stream.flush();
  if (!stream) return Error{ErrorCode::kIo, options.output + " can't be written"};
  return {};
}

/// @return whether all bars are met.
Result<bool> Run(const Options& options) {
  const Result<Bars> bars = ReadBenchBars(options.bars, options.part);
  if (!bars) return bars.error();
  std::vector<Measured> measured;
  json context;
  for (const std::string& file : options.raw) {
    Result<json> read = ReadMeasurements(file, &measured);
    if (!read) return read.error();
    context = std::move(read).value();
  }
  std::vector<PoseRecord> records;
  for (const std::string& file : options.poses) {
    if (const Result<void> read = ReadPoseRecords(file, &records); !read) return read.error();
  }
  const PoseComparison poses(records);
  Result<json> rows = MakeRows(measured, poses, *bars, options.bars);
  if (!rows) return rows.error();
  if (!records.empty()) std::printf("%s\n", PoseTable(poses).c_str());
  PrintTable(*rows);
  for (const PoseSummary& summary : poses.summaries()) {
    rows->push_back(MakePoseRow(summary, poses));
  }
  if (const Result<void> written = WriteJson(options, context, *rows); !written) {
    return written.error();
  }
  return std::none_of(rows->begin(), rows->end(), [](const json& row) {
    return row["met"].is_boolean() && !row["met"].get<bool>();
  });
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Options options;
  CLI::App app("Table and JSON of a benchmark's medians, with bars and peers",
               "vantage-bench-table");
  app.add_option("measurements", options.raw, "JSON of Google Benchmark programs")->required();
  app.add_option("--poses", options.poses, "JSON lines of pose_comparison");
  app.add_option("--bars", options.bars, "CSV of part,benchmark,bar,peer")->required();
  app.add_option("--part", options.part, "which part's bars count")->required();
  app.add_option("--commit", options.commit, "what was measured");
  app.add_option("--output", options.output, "JSON to write")->required();
  app.add_flag("--check", options.check, "exit 1 when a bar is not met");
  if (const std::optional<int> code = vantage::ParseCommandLine(app, argc, argv)) return *code;
  const vantage::Result<bool> met = vantage::Run(options);
  if (!met) {
    std::fprintf(stderr, "vantage-bench-table: %s\n", met.error().message.c_str());
    return 2;
  }
  return options.check && !*met ? 1 : 0;
}
