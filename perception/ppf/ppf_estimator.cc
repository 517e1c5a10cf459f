#include "perception/ppf/ppf_estimator.h"

#include <utility>

#include "perception/ppf/ppf_proposer.h"

namespace vantage {
Result<void> PpfEstimatorParameters::Validate() const {
  for (const Result<void>& valid : {table.Validate(), voting.Validate(), estimation.Validate()}) {
    if (!valid) return valid;
  }
  return {};
}

Result<std::unique_ptr<PoseEstimator>> CreatePpfEstimator(
    std::vector<PpfModel> models, const PpfEstimatorParameters& parameters) {
  if (Result<void> valid = parameters.Validate(); !valid) return valid.error();
  std::vector<KnownModel> known;
  std::vector<PpfProposer::Model> voted;
  for (PpfModel& model : models) {
    Result<KnownModel> made = MakeKnownModel(std::move(model.object), model.table);
    if (!made) return made.error();
    voted.push_back({std::move(model.table), made->object.center, made->object.symmetry});
    known.push_back(std::move(made).value());
  }
  return PoseEstimator::Create(std::move(known),
                               std::make_unique<PpfProposer>(std::move(voted), parameters.voting),
                               parameters.estimation);
}

Result<std::unique_ptr<PoseEstimator>> CreatePpfEstimator(
    std::vector<ObjectModel> models, const PpfEstimatorParameters& parameters) {
  if (Result<void> valid = parameters.Validate(); !valid) return valid.error();
  std::vector<PpfModel> trained;
  for (ObjectModel& model : models) {
    Result<PpfTable> table = PpfTable::Train(model.samples, model.diameter, parameters.table);
    if (!table) {
      return Error{table.error().code, "model \"" + model.id + "\": " + table.error().message};
    }
    trained.push_back({std::move(model), std::move(table).value()});
  }
  return CreatePpfEstimator(std::move(trained), parameters);
}

}  // namespace vantage
