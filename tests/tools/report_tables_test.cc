// The text forms of a report: terminal, CSV, JSON.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tools/support/report_page.h"

namespace vantage {
namespace {

constexpr double kMm = 1e-3;  // m

// Two objects, one found (0.5 deg and 1.25 mm at last), one not; nothing extra.
RunMetrics Metrics() {
  RunMetrics metrics;
  metrics.objects.resize(2);
  ObjectHistory& found = metrics.objects[0];
  found.model_id = "mug";
  found.instance = 3;
  found.num_views = 2;
  found.seconds = 4.5;
  found.converged = true;
  found.detected = {
      PoseError{4.0 * kDegree, 6.0 * kMm}, std::nullopt, PoseError{2.0 * kDegree, 1.0 * kMm}};
  found.fused = {
      std::nullopt, PoseError{4.0 * kDegree, 6.0 * kMm}, PoseError{0.5 * kDegree, 1.25 * kMm}};
  found.refined = {std::nullopt, std::nullopt, PoseError{0.0625 * kDegree, 0.5 * kMm}};
  metrics.objects[1].model_id = "gear";
  return metrics;
}

std::vector<std::vector<std::string>> Fields(const std::string& csv) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    rows.emplace_back(1);
    for (const char c : line) {
      if (c == ',') {
        rows.back().emplace_back();
      } else {
        rows.back().back() += c;
      }
    }
  }
  return rows;
}

TEST(ErrorsCsv, HasARowForEachViewOfAnObject) {
  const auto rows = Fields(ErrorsCsv(Metrics()));
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0],
            (std::vector<std::string>{"object",
                                      "instance",
                                      "view",
                                      "detected_deg",
                                      "detected_mm",
                                      "fused_deg",
                                      "fused_mm",
                                      "refined_deg",
                                      "refined_mm"}));
  for (const auto& row : rows) EXPECT_EQ(row.size(), 9U);
  EXPECT_EQ(rows[1][0], "mug");
  EXPECT_EQ(rows[1][1], "3");
  EXPECT_EQ(rows[1][2], "1");
  EXPECT_NEAR(std::stod(rows[1][3]), 4.0, 1e-6);
  EXPECT_NEAR(std::stod(rows[1][4]), 6.0, 1e-6);
  EXPECT_EQ(rows[1][5], "") << "no estimate is an empty field, not 0";
  EXPECT_EQ(rows[2][3], "");
  EXPECT_EQ(rows[3][2], "3");
  EXPECT_NEAR(std::stod(rows[3][5]), 0.5, 1e-6);
  EXPECT_NEAR(std::stod(rows[3][6]), 1.25, 1e-6);
  EXPECT_EQ(rows[2][7], "") << "not refined yet";
  EXPECT_NEAR(std::stod(rows[3][7]), 0.0625, 1e-6);
  EXPECT_NEAR(std::stod(rows[3][8]), 0.5, 1e-6);
}

TEST(ReportJson, ParsesAndTellsTheSame) {
  const ReportLimits limits{.rotation_deg = 2.0, .position_mm = 3.0};
  RunMetrics metrics = Metrics();
  nlohmann::json report = nlohmann::json::parse(ReportJson(metrics, limits));
  EXPECT_EQ(report["met"], false) << "one object is missing";
  EXPECT_DOUBLE_EQ(report["limits"]["rotation_deg"], 2.0);
  EXPECT_DOUBLE_EQ(report["limits"]["position_mm"], 3.0);
  EXPECT_TRUE(report["extra"].empty());
  ASSERT_EQ(report["objects"].size(), 2U);
  const nlohmann::json& mug = report["objects"][0];
  EXPECT_EQ(mug["model"], "mug");
  EXPECT_EQ(mug["instance"], 3);
  EXPECT_EQ(mug["num_views"], 2);
  EXPECT_EQ(mug["converged"], true);
  EXPECT_DOUBLE_EQ(mug["seconds"], 4.5);
  EXPECT_NEAR(mug["error"]["rotation_deg"], 0.5, 1e-9);
  EXPECT_NEAR(mug["error"]["position_mm"], 1.25, 1e-9);
  EXPECT_NEAR(mug["median_detection_deg"], 3.0, 1e-9);
  EXPECT_NEAR(mug["refined_error"]["rotation_deg"], 0.0625, 1e-9);
  EXPECT_TRUE(mug["views"][1]["refined"].is_null());
  EXPECT_NEAR(mug["views"][2]["refined"]["position_mm"], 0.5, 1e-9);
  ASSERT_EQ(mug["views"].size(), 3U);
  EXPECT_TRUE(mug["views"][0]["fused"].is_null());
  EXPECT_NEAR(mug["views"][1]["fused"]["rotation_deg"], 4.0, 1e-9);
  EXPECT_TRUE(mug["views"][1]["detected"].is_null());
  const nlohmann::json& gear = report["objects"][1];
  EXPECT_TRUE(gear["instance"].is_null());
  EXPECT_TRUE(gear["error"].is_null());
  EXPECT_TRUE(gear["median_detection_deg"].is_null());

  metrics.objects.pop_back();
  report = nlohmann::json::parse(ReportJson(metrics, limits));
  EXPECT_EQ(report["met"], true);
  metrics.extra = {"mug \"9\""};
  report = nlohmann::json::parse(ReportJson(metrics, limits));
  EXPECT_EQ(report["met"], false);
  EXPECT_EQ(report["extra"][0], "mug \"9\"");
}

TEST(ReportJson, LimitsAreInDegreesAndMillimetres) {
  RunMetrics metrics = Metrics();
  metrics.objects.pop_back();
  const auto met = [&](double rotation_deg, double position_mm) {
    const ReportLimits limits{.rotation_deg = rotation_deg, .position_mm = position_mm};
    const bool json = nlohmann::json::parse(ReportJson(metrics, limits))["met"];
    const bool table = SummaryTable(metrics, limits).find("NOT met") == std::string::npos;
    EXPECT_EQ(json, table);
    return json;
  };
  EXPECT_TRUE(met(0.51, 1.26));
  EXPECT_FALSE(met(0.49, 1.26));
  EXPECT_FALSE(met(0.51, 1.24));
}

TEST(SummaryTable, TellsWhatWasFoundAndWhatNot) {
  RunMetrics metrics = Metrics();
  metrics.extra = {"duck 8"};
  const std::string table = SummaryTable(metrics, {});
  for (const char* part : {"mug",
                           "0.50",
                           "1.25",
                           "0.062",
                           "4.5",
                           "(not found)",
                           "duck 8",
                           "is reported but not in the truth",
                           "mug: fused 0.50 deg, median single detection 3.00 deg",
                           "2 deg modulo symmetry, 3 mm: NOT met"}) {
    EXPECT_NE(table.find(part), std::string::npos) << part << " in\n" << table;
  }
  EXPECT_EQ(table.find("gear: fused"), std::string::npos);
  metrics.objects[0].converged = false;
  EXPECT_NE(SummaryTable(metrics, {}).find("(not converged)"), std::string::npos);
}

TEST(ViewTable, HasALineForEachViewOfAFoundObject) {
  const std::string table = ViewTable(Metrics());
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 4);
  EXPECT_NE(
      table.find("    3 mug                       2.00           1.00         0.50        1.25"
                 "          0.062          0.50"),
      std::string::npos)
      << table;
}

}  // namespace
}  // namespace vantage
