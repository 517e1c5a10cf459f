#include "perception/shot/shot_estimator.h"

#include <utility>

#include "perception/ppf/ppf_table.h"
#include "perception/shot/shot_proposer.h"

namespace vantage {

Result<void> ShotEstimatorParameters::Validate() const {
  if (Result<void> valid = shot.Validate(); !valid) return valid;
  return estimation.Validate();
}

Result<std::unique_ptr<PoseEstimator>> CreateShotEstimator(
    std::vector<ObjectModel> models, const ShotEstimatorParameters& parameters) {
  if (Result<void> valid = parameters.Validate(); !valid) return valid.error();
  Result<std::unique_ptr<ShotProposer>> proposer = ShotProposer::Create(models, parameters.shot);
  if (!proposer) return proposer.error();
  std::vector<KnownModel> known;
  for (ObjectModel& model : models) {
    // Only to find the model's alternatives.
    const Result<PpfTable> table = PpfTable::Train(model.samples, model.diameter, {});
    if (!table) {
      return Error{table.error().code, "model \"" + model.id + "\": " + table.error().message};
    }
    Result<KnownModel> made = MakeKnownModel(std::move(model), *table);
    if (!made) return made.error();
    known.push_back(std::move(made).value());
  }
  return PoseEstimator::Create(
      std::move(known), std::move(proposer).value(), parameters.estimation);
}

}  // namespace vantage
