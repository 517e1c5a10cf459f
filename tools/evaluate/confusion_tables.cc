#include "tools/evaluate/confusion_tables.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <system_error>
#include <utility>
#include <vector>

#include "common/format.h"
#include "fusion/confusion/contingency_file.h"
#include "perception/model/symmetry_text.h"
#include "tools/contingency/measure_table.h"
#include "tools/contingency/trial_setup.h"
#include "tools/contingency/work_file.h"
#include "tools/support/hash.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostConfusedBy = 5;
constexpr double kLeastShown = 0.002;  // Mean share of a mode that is told.

std::string TextOf(const ContingencyKey& key) {
  std::string text;
  for (const std::string& field : {key.model_id,
                                   key.mesh_hash,
                                   key.estimator,
                                   key.estimator_parameters,
                                   key.sensor,
                                   key.stopping}) {
    text += field;
    text += '\n';
  }
  return text + Format("%ju %d", static_cast<uintmax_t>(key.seed), key.num_directions);
}

// That of the model's folder, where it is there and fits.
std::optional<FoundTable> FromModel(const ContingencyKey& key, const fs::path& models) {
  const fs::path file = models / key.model_id / "confusion-ppf.bin";
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return {};
  Result<ContingencyTable> table = ReadContingencyTable(file);
  ContingencyKey expected = key;
  expected.stopping.clear();
  if (!table || !CheckContingencyKey(table->key, expected, file.string()) || !table->IsComplete() ||
      table->key.num_directions < key.num_directions) {
    return {};
  }
  return FoundTable{std::move(table).value(), "model"};
}

}  // namespace

Result<std::optional<FoundTable>> FindOrMeasureTable(
    const ObjectModel& model,
    const ConfusionTableParameters& parameters,
    const std::stop_token& stop,
    const std::function<void(int64_t, int64_t)>& progress) {
  for (const Result<void>& valid : {parameters.trials.Validate(), parameters.stopping.Validate()}) {
    if (!valid) return valid.error();
  }
  const TrialPlan plan{model.id, parameters.seed, model.symmetry, parameters.stopping};
  const ContingencyKey key =
      MakeKey(model, parameters.trials, plan, NumDirections(parameters.k), 0);
  if (auto found = FromModel(key, parameters.models)) return std::optional(std::move(*found));

  std::error_code error;
  fs::create_directories(parameters.cache, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 Format("%s can't be made: %s", parameters.cache.c_str(), error.message().c_str())};
  }
  Result<WorkFile> work = WorkFile::Open(
      parameters.cache /
          Format("%s-%016jx.txt", model.id.c_str(), static_cast<uintmax_t>(Fnv1a(TextOf(key)))),
      key);
  if (!work) return work.error();
  if (work->table().IsComplete()) return std::optional(FoundTable{work->table(), "cache"});
  TrialUnits units;
  units.directions.resize(static_cast<size_t>(key.num_directions));
  std::iota(units.directions.begin(), units.directions.end(), 0);
  const Result<bool> is_complete = MeasureTable(
      plan,
      units,
      parameters.threads,
      SimulatedDetectors(model, parameters.trials),
      stop,
      [&progress](const MeasureProgress& done) {
        if (progress) progress(done.units_done, done.units_total);
      },
      &*work);
  if (!is_complete) return is_complete.error();
  if (!*is_complete) return std::optional<FoundTable>();
  return std::optional(FoundTable{work->table(), "measured"});
}

TableFacts FactsOf(const ObjectModel& model,
                   const FoundTable& found,
                   const ConfusionModel& confusion) {
  TableFacts facts;
  facts.model_id = model.id;
  facts.symmetry = SymmetryText(model.symmetry);
  facts.source = found.source;
  facts.num_directions = found.table.key.num_directions;
  facts.num_rows = static_cast<int>(found.table.rows.size());
  facts.num_trials = found.table.NumTrials();
  facts.num_modes = confusion.num_modes();
  const int num_directions = confusion.num_directions();
  std::vector<ConfusedBy> modes(static_cast<size_t>(confusion.num_modes()));
  for (int direction = 0; direction < num_directions; ++direction) {
    facts.missed += (confusion.Missed(direction) - confusion.Scattered(direction)) / num_directions;
    for (const ConfusionModel::Share& share : confusion.SharesFrom(direction)) {
      ConfusedBy& mode = modes[static_cast<size_t>(share.mode)];
      mode.share += share.share / num_directions;
      mode.largest_share = std::max(mode.largest_share, share.share);
    }
  }
  facts.right = modes.front().share;
  for (int mode = 1; mode < confusion.num_modes(); ++mode) {
    ConfusedBy& one = modes[static_cast<size_t>(mode)];
    const Eigen::AngleAxisd turn(confusion.Difference(mode));
    one.angle_deg = turn.angle() / kDegree;
    one.axis = turn.axis();
    if (one.share >= kLeastShown) facts.confused_by.push_back(one);
  }
  std::stable_sort(facts.confused_by.begin(),
                   facts.confused_by.end(),
                   [](const ConfusedBy& a, const ConfusedBy& b) { return a.share > b.share; });
  facts.confused_by.resize(std::min(facts.confused_by.size(), kMostConfusedBy));
  return facts;
}

}  // namespace vantage
