#include "tools/support/pose_summary.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tools/support/pose_table.h"

namespace vantage {
namespace {

PoseRecord Record(const std::string& model, const std::string& estimator, int view, double ms) {
  PoseRecord record;
  record.model = model;
  record.estimator = estimator;
  record.view = view;
  record.is_peer = estimator.rfind("peer", 0) == 0;
  record.ms = ms;
  record.stages_ms = {{"matching", ms}};
  record.is_within = record.is_success = true;
  record.angle_deg = 0.1 * view;
  record.distance_mm = 0.2 * view;
  return record;
}

// 200 views of ours; of the first four a fast peer that fails twice and a slow one that never does.
std::vector<PoseRecord> Records() {
  std::vector<PoseRecord> records;
  for (int view = 0; view < 200; ++view) {
    records.push_back(Record("cup", "ours", view, view < 4 ? 1.0 + view : 10.0 + view));
    if (view >= 4) continue;
    records.push_back(Record("cup", "peer-fast", view, 20.0 + view));
    records.back().is_within = view >= 2;
    records.back().is_success = view >= 2;
    records.push_back(Record("cup", "peer-slow", view, 200.0));
  }
  records.push_back(Record("box", "ours", 0, 7.0));
  records.back().is_within = false;
  records.push_back(Record("box", "peer-fast", 0, 70.0));
  return records;
}

double Value(const PoseComparison& comparison, const std::string& name) {
  const Result<PoseComparison::Figure> figure = comparison.Find(name);
  EXPECT_TRUE(figure.ok()) << name;
  return figure.ok() ? figure->value : std::nan("");
}

TEST(PoseComparison, SummariesByModelThenEstimatorTotalsLast) {
  const PoseComparison comparison(Records());
  std::vector<std::string> names;
  for (const PoseSummary& each : comparison.summaries()) {
    names.push_back(each.model + "/" + each.estimator);
  }
  EXPECT_EQ(names,
            (std::vector<std::string>{"cup/ours",
                                      "cup/peer-fast",
                                      "cup/peer-slow",
                                      "box/ours",
                                      "box/peer-fast",
                                      "all/ours",
                                      "all/peer-fast",
                                      "all/peer-slow"}));
}

TEST(PoseComparison, MediansTailAndRates) {
  const PoseComparison comparison(Records());
  const PoseSummary& fast = comparison.summaries()[1];
  EXPECT_TRUE(fast.is_peer);
  EXPECT_EQ(fast.views, 4U);
  EXPECT_DOUBLE_EQ(fast.median_ms, 21.5);
  EXPECT_DOUBLE_EQ(fast.p99_ms, 23.0);
  EXPECT_DOUBLE_EQ(fast.within_pct, 50.0);
  EXPECT_DOUBLE_EQ(fast.median_deg, 0.25) << "of those within, views 2 and 3";
  EXPECT_DOUBLE_EQ(fast.median_mm, 0.5);
  EXPECT_DOUBLE_EQ(fast.stages_ms.at("matching"), 21.5);
  EXPECT_DOUBLE_EQ(Value(comparison, "ours/cup/p99_ms"), 207.0) << "two of 200 take longer";
  EXPECT_DOUBLE_EQ(Value(comparison, "ours/box/within_pct"), 0.0);
  EXPECT_DOUBLE_EQ(Value(comparison, "ours/box/success_pct"), 100.0);
  EXPECT_TRUE(std::isnan(comparison.summaries()[3].median_deg)) << "none is within";
}

TEST(PoseComparison, AbsentStageTookNoTime) {
  std::vector<PoseRecord> records = {Record("cup", "ours", 0, 1.0), Record("cup", "ours", 1, 1.0)};
  records[0].stages_ms["icp"] = 4.0;
  EXPECT_DOUBLE_EQ(PoseComparison(records).summaries()[0].stages_ms.at("icp"), 2.0);
}

TEST(PoseComparison, PeersAreComparedOnTheirViews) {
  const PoseComparison comparison(Records());
  EXPECT_EQ(comparison.FastestPeer("cup")->estimator, "peer-fast");
  EXPECT_EQ(comparison.MostSuccessfulPeer("cup")->estimator, "peer-slow");
  EXPECT_EQ(comparison.FastestPeer("jar"), nullptr);
  EXPECT_EQ(comparison.BesidePeers("cup", "ours")->views, 4U);
  EXPECT_EQ(comparison.BesidePeers("cup", "peer-fast"), nullptr) << "only ours";
  EXPECT_DOUBLE_EQ(Value(comparison, "ours/cup/times_faster_than_fastest_peer"), 21.5 / 2.5);
  EXPECT_DOUBLE_EQ(Value(comparison, "ours/cup/times_faster_than_most_successful_peer"),
                   200.0 / 2.5);
  EXPECT_DOUBLE_EQ(Value(comparison, "ours/cup/success_above_peers_pct"), 0.0);
}

TEST(PoseComparison, EveryModelMeansTheWorst) {
  const PoseComparison comparison(Records());
  EXPECT_EQ(comparison.Find("ours/every/p99_ms")->model, "cup");
  EXPECT_DOUBLE_EQ(Value(comparison, "ours/every/p99_ms"), 207.0);
  EXPECT_EQ(comparison.Find("ours/every/within_pct")->model, "box");
  EXPECT_DOUBLE_EQ(Value(comparison, "ours/every/times_faster_than_fastest_peer"), 21.5 / 2.5);
}

TEST(PoseComparison, UnknownFiguresAreErrors) {
  const PoseComparison comparison(Records());
  for (const char* name : {"ours/cup/beauty",
                           "ours/jar/p99_ms",
                           "theirs/cup/p99_ms",
                           "theirs/every/p99_ms",
                           "ours/p99_ms",
                           "ours",
                           "",
                           "//"}) {
    EXPECT_FALSE(comparison.Find(name).ok()) << name;
  }
  const PoseComparison alone(std::vector<PoseRecord>{Record("cup", "ours", 0, 1.0)});
  EXPECT_FALSE(alone.Find("ours/cup/times_faster_than_fastest_peer").ok());
  EXPECT_TRUE(PoseComparison({}).summaries().empty());
}

TEST(PoseTable, HasALineForEachSummary) {
  const std::string table = PoseTable(PoseComparison(Records()));
  EXPECT_NE(table.find("peer-slow"), std::string::npos);
  EXPECT_NE(table.find("207.00"), std::string::npos) << table;
}

}  // namespace
}  // namespace vantage
