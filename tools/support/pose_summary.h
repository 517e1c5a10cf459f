#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/support/pose_records.h"

namespace vantage {

/// What one estimator gave over the views of one model or of all.
struct PoseSummary {
  std::string model;  ///< or PoseComparison::kAll
  std::string estimator;
  bool is_peer = false;
  size_t views = 0;
  double median_ms = 0.0;
  double p99_ms = 0.0;                      ///< least that 99 % of the views don't exceed
  std::map<std::string, double> stages_ms;  ///< medians; a stage that a view lacks took 0
  double within_pct = 0.0;
  double success_pct = 0.0;
  double median_deg = 0.0;  ///< of the views that are within; NaN without any
  double median_mm = 0.0;   ///< the same
};

/// How whole pose estimators compare on the same views.
class PoseComparison {
 public:
  static constexpr const char* kAll = "all";
  static constexpr const char* kEvery = "every";

  explicit PoseComparison(std::span<const PoseRecord> records);

  /// By model in the records' order, the last one kAll; then by estimator in their order.
  [[nodiscard]] const std::vector<PoseSummary>& summaries() const { return summaries_; }
  /// Of a model's peers the one with the least median time; null without peers.
  [[nodiscard]] const PoseSummary* FastestPeer(const std::string& model) const;
  /// The one with the most successes, of equal ones the faster; null without peers.
  [[nodiscard]] const PoseSummary* MostSuccessfulPeer(const std::string& model) const;
  /// One of our estimators on those views alone that peers had too; null where there is none.
  [[nodiscard]] const PoseSummary* BesidePeers(const std::string& model,
                                               const std::string& estimator) const;

  struct Figure {
    double value = 0.0;
    std::string unit;
    std::string model;  ///< that has it
  };
  /// A figure by its name ESTIMATOR/MODEL/WHAT, as bars have it. MODEL may be kAll, or kEvery: then
  /// it is the worst of the models'. WHAT is one of median_ms, p99_ms, success_pct, within_pct and,
  /// on the views that the peers had, times_faster_than_fastest_peer,
  /// times_faster_than_most_successful_peer, success_above_peers_pct (percentage points above the
  /// most successful one). Errors: no such figure, no such summary, no peer.
  [[nodiscard]] Result<Figure> Find(const std::string& name) const;

 private:
  [[nodiscard]] const PoseSummary* Summary(const std::string& model,
                                           const std::string& estimator) const;
  [[nodiscard]] Result<Figure> Of(const std::string& estimator,
                                  const std::string& model,
                                  const std::string& what) const;

  std::vector<PoseSummary> summaries_;
  std::vector<PoseSummary> beside_peers_;  // Of ours.
};

}  // namespace vantage
