// Runs vantage-bench-table as tools/bench does.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "perception/model/file_bytes.h"
#include "tests/tools/run_program.h"

namespace vantage {
namespace {

constexpr const char* kMeasured = R"({
 "context": {"num_cpus": 2, "mhz_per_cpu": 3000},
 "benchmarks": [
  {"run_name": "Ours", "aggregate_name": "mean", "cpu_time": 99.0, "time_unit": "us"},
  {"run_name": "Ours", "aggregate_name": "median", "cpu_time": 20.0, "real_time": 21.0,
   "time_unit": "us", "iterations": 5, "error_deg": 0.25},
  {"run_name": "Peer", "aggregate_name": "median", "cpu_time": 50.0, "time_unit": "us"},
  {"run_name": "Slow", "aggregate_name": "median", "cpu_time": 3.0, "time_unit": "ms"}
 ]
})";

class BenchTable : public ScratchTest {
 protected:
  ProgramOutput Run(const std::string& bars, const std::string& measured, const std::string& more) {
    std::ofstream(scratch() / "bars.csv") << bars;
    std::ofstream(scratch() / "raw.json") << measured;
    return RunProgram("vantage-bench-table",
                      "raw.json --bars bars.csv --part p --output out.json " + more,
                      scratch());
  }
  void ExpectRefused(const std::string& bars,
                     const std::string& measured,
                     const std::string& part) {
    const ProgramOutput output = Run(bars, measured, "--check");
    EXPECT_EQ(output.exit_code, 2) << output.text;
    EXPECT_NE(output.text.find(part), std::string::npos) << output.text;
    EXPECT_FALSE(std::filesystem::exists(scratch() / "out.json"));
  }
  [[nodiscard]] nlohmann::json Out() const {
    const Result<std::string> text = ReadFileBytes(scratch() / "out.json", 1U << 20U);
    EXPECT_TRUE(text.ok());
    return nlohmann::json::parse(text.ok() ? *text : "null");
  }
};

TEST_F(BenchTable, BarsThatAreMet) {
  const ProgramOutput output =
      Run("# part,benchmark,bar,peer\np,Ours,20,Peer\nq,Other,1,\np,Slow,,\n",
          kMeasured,
          "--check --commit abc");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  const nlohmann::json out = Out();
  EXPECT_EQ(out["commit"], "abc");
  EXPECT_EQ(out["machine"]["num_cpus"], 2);
  ASSERT_EQ(out["rows"].size(), 3U);
  const nlohmann::json& ours = out["rows"][0];
  EXPECT_EQ(ours["name"], "Ours");
  EXPECT_EQ(ours["value"], 20.0);
  EXPECT_EQ(ours["unit"], "us");
  EXPECT_EQ(ours["bar"], 20.0);
  EXPECT_EQ(ours["met"], true);
  EXPECT_EQ(ours["peer"], "Peer");
  EXPECT_EQ(ours["peer_value"], 50.0);
  EXPECT_EQ(ours["ratio"], 2.5);
  ASSERT_EQ(ours["accuracy"].size(), 1U);
  EXPECT_EQ(ours["accuracy"]["error_deg"], 0.25);
  EXPECT_TRUE(out["rows"][2]["bar"].is_null());
  EXPECT_TRUE(out["rows"][2]["met"].is_null());
  EXPECT_NE(output.text.find("vs Peer"), std::string::npos) << output.text;
  EXPECT_NE(output.text.find("error_deg 0.25"), std::string::npos) << output.text;
}

TEST_F(BenchTable, BarThatIsNotMet) {
  const std::string bars = "p,Ours,19.9,Peer\np,Slow,4,\n";
  const ProgramOutput output = Run(bars, kMeasured, "--check");
  EXPECT_EQ(output.exit_code, 1) << output.text;
  EXPECT_NE(output.text.find("NO"), std::string::npos) << output.text;
  EXPECT_EQ(Out()["rows"][0]["met"], false);
  EXPECT_EQ(Out()["rows"][2]["met"], true);
  EXPECT_EQ(Run(bars, kMeasured, "").exit_code, 0) << "only --check fails";
}

TEST_F(BenchTable, PeerOfAnotherUnitIsNoPeer) {
  ASSERT_EQ(Run("p,Ours,,Slow\n", kMeasured, "").exit_code, 0);
  EXPECT_TRUE(Out()["rows"][0]["ratio"].is_null());
}

TEST_F(BenchTable, APeerMayBeTheBar) {
  ASSERT_EQ(Run("p,Ours,peer,Peer\n", kMeasured, "--check").exit_code, 0);
  EXPECT_EQ(Out()["rows"][0]["bar"], 50.0);
  EXPECT_EQ(Out()["rows"][0]["met"], true);
  EXPECT_EQ(Run("p,Peer,peer,Ours\n", kMeasured, "--check").exit_code, 1);
  std::filesystem::remove(scratch() / "out.json");
  ExpectRefused("p,Ours,peer,Slow\n", kMeasured, "holds Ours against Slow, which did not run");
  ExpectRefused("p,Ours,peer,\n", kMeasured, "or peer where there is one");
}

TEST_F(BenchTable, CountersHaveBars) {
  const ProgramOutput output = Run("p,Ours/error_deg,0.3,\n", kMeasured, "--check");
  ASSERT_EQ(output.exit_code, 0) << output.text;
  ASSERT_EQ(Out()["rows"].size(), 4U);
  EXPECT_EQ(Out()["rows"][3]["name"], "Ours/error_deg");
  EXPECT_EQ(Out()["rows"][3]["value"], 0.25);
  EXPECT_EQ(Run("p,Ours/error_deg,0.2,\n", kMeasured, "--check").exit_code, 1);
  std::filesystem::remove(scratch() / "out.json");
  ExpectRefused("p,Ours/iterations,9,\n", kMeasured, "Ours/iterations");
}

TEST_F(BenchTable, OptionalBenchmarksMayBeAbsent) {
  const ProgramOutput output = Run("p,?Gone,5,\np,?Ours,20,\n", kMeasured, "--check");
  EXPECT_EQ(output.exit_code, 0) << output.text;
  EXPECT_NE(output.text.find("not measured, as its data are not there: Gone"), std::string::npos);
  EXPECT_EQ(Out()["rows"][0]["met"], true);
  EXPECT_EQ(Run("p,?Ours,19,\n", kMeasured, "--check").exit_code, 1);
}

constexpr const char* kPoses =
    R"({"model":"cup","estimator":"ours","view":0,"is_peer":false,"ms":2,"stages_ms":{"a":2},)"
    R"("within":true,"success":true,"angle_deg":0.5,"distance_mm":1})"
    "\n"
    R"({"model":"cup","estimator":"theirs","view":0,"is_peer":true,"ms":50,"stages_ms":{},)"
    R"("within":false,"success":false})"
    "\n";

TEST_F(BenchTable, WholeEstimatorsBesideSeveralPrograms) {
  std::ofstream(scratch() / "poses.jsonl") << kPoses;
  std::ofstream(scratch() / "more.json")
      << R"({"context": {"num_cpus": 4}, "benchmarks": [{"run_name": "More",
            "aggregate_name": "median", "cpu_time": 1.0, "time_unit": "us"}]})";
  const std::string bars =
      "p,Ours,20,\np,More,2,\np,ours/every/median_ms,1.5,\n"
      "p,ours/all/times_faster_than_fastest_peer,>=25,\n"
      "p,ours/cup/success_pct,>=99,\n";
  const ProgramOutput output = Run(bars, kMeasured, "more.json --poses poses.jsonl --check");
  EXPECT_EQ(output.exit_code, 1) << output.text;
  EXPECT_NE(output.text.find("theirs"), std::string::npos) << output.text;
  const nlohmann::json out = Out();
  std::map<std::string, nlohmann::json> rows;
  for (const nlohmann::json& row : out["rows"]) rows[row["name"]] = row;
  EXPECT_EQ(rows["More"]["met"], true);
  EXPECT_EQ(rows["ours/every/median_ms"]["value"], 2.0);
  EXPECT_EQ(rows["ours/every/median_ms"]["met"], false);
  EXPECT_EQ(rows["ours/every/median_ms"]["model"], "cup");
  EXPECT_EQ(rows["ours/all/times_faster_than_fastest_peer"]["value"], 25.0);
  EXPECT_EQ(rows["ours/all/times_faster_than_fastest_peer"]["met"], true) << "a lower bound";
  EXPECT_EQ(rows["ours/cup/success_pct"]["met"], true);
  const nlohmann::json& ours = rows["ours/cup"];
  EXPECT_EQ(ours["value"], 2.0);
  EXPECT_EQ(ours["peer"], "theirs/cup");
  EXPECT_EQ(ours["peer_value"], 50.0);
  EXPECT_EQ(ours["ratio"], 25.0);
  EXPECT_EQ(ours["accuracy"]["success_pct"], 100.0);
  EXPECT_EQ(ours["accuracy"]["median_deg"], 0.5);
  EXPECT_EQ(ours["accuracy"]["a_ms"], 2.0);
  EXPECT_TRUE(rows["theirs/cup"]["ratio"].is_null());
  EXPECT_FALSE(rows["theirs/cup"]["accuracy"].contains("median_deg")) << "none was within";
}

TEST_F(BenchTable, BadEstimatesAreErrors) {
  std::ofstream(scratch() / "poses.jsonl") << kPoses << "[]\n";
  const ProgramOutput output = Run("", kMeasured, "--poses poses.jsonl");
  EXPECT_EQ(output.exit_code, 2) << output.text;
  EXPECT_NE(output.text.find("poses.jsonl:3"), std::string::npos) << output.text;
  EXPECT_EQ(Run("", kMeasured, "--poses none.jsonl").exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(scratch() / "out.json"));
}

TEST_F(BenchTable, MissingBenchmarkIsAnError) { ExpectRefused("p,Gone,5,\n", kMeasured, "Gone"); }

TEST_F(BenchTable, BadFilesAreErrors) {
  ExpectRefused("p,Ours\n", kMeasured, "bars.csv:1");
  ExpectRefused("\np,Ours,fast,\n", kMeasured, "bars.csv:2: bar \"fast\"");
  ExpectRefused("p,Ours,-1,\n", kMeasured, "expected a positive number");
  ExpectRefused("p,Ours,>=,\n", kMeasured, "expected a positive number");
  ExpectRefused("p,ours/every/p99_ms,8,\n", kMeasured, "ours/every/p99_ms");
  const std::string bars = "p,Ours,20,\n";
  ExpectRefused(bars, "", "raw.json");
  ExpectRefused(bars, "{\"benchmarks\": [", "raw.json");
  ExpectRefused(bars, "[1, 2]", "raw.json");
  ExpectRefused(bars, "{\"context\": {}}", "raw.json");
  const std::string no_bars = "raw.json --bars none.csv --part p --output out.json";
  EXPECT_EQ(RunProgram("vantage-bench-table", no_bars, scratch()).exit_code, 2);
  EXPECT_EQ(Run(bars, kMeasured, "--nonsense").exit_code, 2);
}

}  // namespace
}  // namespace vantage
