#include "perception/ppf/ppf_estimator.h"

#include <utility>

namespace vantage {
namespace {

// Votes with the models' tables.
class VotingProposer : public PoseProposer {
 public:
  VotingProposer(std::vector<PpfTable> tables,
                 std::vector<Eigen::Vector3d> centers,
                 const PpfVotingParameters& parameters)
      : tables_(std::move(tables)), centers_(std::move(centers)), parameters_(parameters) {}

  [[nodiscard]] double Spacing(size_t model) const override {
    return tables_[model].parameters().sample_distance * tables_[model].diameter();
  }
  std::span<const PoseHypothesis> Propose(size_t model,
                                          std::span<const SurfacePoint> scene,
                                          Rng& rng) override {
    found_ = VotePoses(tables_[model], scene, centers_[model], parameters_, rng);
    return found_;
  }

 private:
  std::vector<PpfTable> tables_;
  std::vector<Eigen::Vector3d> centers_;
  PpfVotingParameters parameters_;
  std::vector<PoseHypothesis> found_;
};

}  // namespace

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
  std::vector<PpfTable> tables;
  std::vector<Eigen::Vector3d> centers;
  for (PpfModel& model : models) {
    centers.push_back(model.object.center);
    Result<KnownModel> made = MakeKnownModel(std::move(model.object), model.table);
    if (!made) return made.error();
    known.push_back(std::move(made).value());
    tables.push_back(std::move(model.table));
  }
  return PoseEstimator::Create(
      std::move(known),
      std::make_unique<VotingProposer>(std::move(tables), std::move(centers), parameters.voting),
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
