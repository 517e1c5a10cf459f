// The histogram filter against a straightforward dense one, which holds every cell of the grid and
// sweeps over all of them, as the paper's does, and against the filters that the paper compares it
// with. sigma_cw = 3 degrees, 30 views.
#include <benchmark/benchmark.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "common/symmetry_group.h"
#include "fusion/bayesian_histogram.h"
#include "fusion/bingham/bingham_mixture_filter.h"
#include "fusion/bingham/bingham_smc_filter.h"
#include "fusion/compared/particle_filter.h"
#include "fusion/confusion/accuracy_weights.h"
#include "fusion/confusion/confusion_model.h"
#include "fusion/confusion/mode_belief.h"
#include "fusion/confusion/viewing_direction.h"
#include "fusion/mode_refinement.h"
#include "fusion/orientation_filter.h"
#include "fusion/orientation_histogram.h"
#include "fusion/peaks.h"
#include "fusion/quaternion_mean.h"
#include "fusion/so3_grid.h"
#include "tests/fusion/confusion/synthetic_object.h"

namespace vantage {
namespace {

constexpr double kSigma = 3.0 * kDegree;
constexpr int kNumUpdates = 30;

const So3Grid& Grid(int k = 32) {
  static const So3Grid grid_8(8);
  static const So3Grid grid_32(32);
  static const So3Grid grid_64(64);
  return k == 8 ? grid_8 : k == 32 ? grid_32 : grid_64;
}

class DenseHistogram {
 public:
  explicit DenseHistogram(const So3Grid& grid) : grid_(grid), cells_(grid.ValidCells()) {
    const auto count = static_cast<Eigen::Index>(cells_.size());
    representatives_.resize(4, count);
    areas_.resize(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const So3Grid::Cell cell = cells_[static_cast<size_t>(i)];
      representatives_.col(i) = grid.Representative(cell).coeffs();
      areas_[i] = grid.Area(cell);
    }
    weights_ = Eigen::VectorXd::Zero(count);
    confidence_.resize(count);
  }

  void Clear() { weights_.setZero(); }

  void Add(const Eigen::Quaterniond& q, double w_v) {
    const double cos_cutoff = std::cos(1.5 * kSigma);  // Of half the angle of 3 sigma.
    confidence_.noalias() = (representatives_.transpose() * q.coeffs()).cwiseAbs();
    for (double& value : confidence_) {
      const double angle = 2.0 * std::acos(std::min(1.0, value));
      value = value < cos_cutoff ? 0.0 : std::exp(-angle * angle / (2.0 * kSigma * kSigma));
    }
    weights_ += w_v / confidence_.dot(areas_) * confidence_;
  }

  [[nodiscard]] Eigen::Quaterniond FinalOrientation() const {
    const double w_M = weights_.maxCoeff();
    std::vector<char> taken(cells_.size(), 0);
    std::vector<So3Grid::Neighbor> neighbors;
    double best_mass = -1.0;
    Eigen::Quaterniond best = Eigen::Quaterniond::Identity();
    for (size_t seed = 0; seed < cells_.size(); ++seed) {
      if (taken[seed] != 0 || Weight(seed) < 0.9 * w_M) continue;
      std::vector<size_t> cluster = {seed};
      taken[seed] = 1;
      std::vector<WeightedOrientation> orientations;
      double mass = 0.0;
      for (size_t next = 0; next < cluster.size(); ++next) {
        const size_t i = cluster[next];
        const double share = Weight(i) * areas_[static_cast<Eigen::Index>(i)];
        mass += share;
        orientations.push_back({grid_.Representative(cells_[i]), share});
        grid_.Neighbors(cells_[i], &neighbors);
        for (const So3Grid::Neighbor& neighbor : neighbors) {
          const auto found = std::lower_bound(cells_.begin(), cells_.end(), neighbor.cell);
          const auto place = static_cast<size_t>(found - cells_.begin());
          if (taken[place] != 0 || Weight(place) < 0.7 * w_M) continue;
          taken[place] = 1;
          cluster.push_back(place);
        }
      }
      if (mass <= best_mass) continue;
      best_mass = mass;
      best = WeightedMean(orientations);
    }
    return best;
  }

 private:
  [[nodiscard]] double Weight(size_t i) const { return weights_[static_cast<Eigen::Index>(i)]; }

  const So3Grid& grid_;
  std::vector<So3Grid::Cell> cells_;
  Eigen::Matrix<double, 4, Eigen::Dynamic> representatives_;
  Eigen::VectorXd areas_;
  Eigen::VectorXd weights_;
  Eigen::VectorXd confidence_;
};

// 30 views of one orientation: two thirds near it, the others anywhere.
std::vector<Eigen::Quaterniond> Detections() {
  Rng rng(1);
  const Eigen::Quaterniond truth = rng.Rotation();
  std::vector<Eigen::Quaterniond> detections;
  for (int i = 0; i < kNumUpdates; ++i) {
    const Eigen::Vector3d error(rng.Normal(), rng.Normal(), rng.Normal());
    detections.push_back(i % 3 == 2 ? rng.Rotation() : truth * ExpSo3(1.0 * kDegree * error));
  }
  return detections;
}

// Every update of 30 views, from the first one's untouched histogram on.
void TruncatedUpdate(benchmark::State& state) {
  const std::vector<Eigen::Quaterniond> detections = Detections();
  OrientationHistogram histogram(Grid(static_cast<int>(state.range(0))));
  size_t next = 0;
  for (auto _ : state) {
    if (next == detections.size()) {
      state.PauseTiming();
      histogram = OrientationHistogram(histogram.grid());
      next = 0;
      state.ResumeTiming();
    }
    histogram.Add(detections[next++], kSigma, 1.0);
  }
  state.counters["cells"] = static_cast<double>(histogram.weights().Entries().size());
}

void DenseUpdate(benchmark::State& state) {
  const std::vector<Eigen::Quaterniond> detections = Detections();
  DenseHistogram histogram(Grid());
  size_t next = 0;
  for (auto _ : state) histogram.Add(detections[next++ % detections.size()], 1.0);
  state.counters["cells"] = Grid().num_cells();
}

void FinalOrientationOfThirty(benchmark::State& state) {
  OrientationHistogram histogram(Grid());
  DenseHistogram dense(Grid());
  for (const Eigen::Quaterniond& q : Detections()) {
    histogram.Add(q, kSigma, 1.0);
    dense.Add(q, 1.0);
  }
  PeakParameters parameters;
  parameters.w_mode = parameters.w_max;  // The paper's clusters alone, as in the dense one.
  Eigen::Quaterniond q_f;
  for (auto _ : state) benchmark::DoNotOptimize(q_f = FindPeaks(histogram, parameters).front().q);
  state.counters["deg_from_dense"] = GeodesicAngle(q_f, dense.FinalOrientation()) / kDegree;
}

void DenseFinalOrientation(benchmark::State& state) {
  DenseHistogram histogram(Grid());
  for (const Eigen::Quaterniond& q : Detections()) histogram.Add(q, 1.0);
  for (auto _ : state) benchmark::DoNotOptimize(histogram.FinalOrientation());
}

void AllPeaks(benchmark::State& state) {
  OrientationHistogram histogram(Grid());
  for (const Eigen::Quaterniond& q : Detections()) histogram.Add(q, kSigma, 1.0);
  for (auto _ : state) benchmark::DoNotOptimize(FindPeaks(histogram, {}));
}

void ModeOfThirty(benchmark::State& state) {
  OrientationHistogram histogram(Grid());
  std::vector<OrientationKernel> kernels;
  for (const Eigen::Quaterniond& q : Detections()) {
    histogram.Add(q, kSigma, 1.0);
    kernels.push_back({q, 0.0, 1.0});
  }
  const Eigen::Quaterniond start = FindPeaks(histogram, {}).front().q;
  const SymmetryGroup none = SymmetryGroup::None();
  for (auto _ : state) {
    benchmark::DoNotOptimize(RefineMode(kernels, start, ModeRefinementParameters{}, none));
  }
}

// The posterior of all 4.4 million cells of k = 64.
void BayesianUpdate(benchmark::State& state) {
  const std::vector<Eigen::Quaterniond> detections = Detections();
  BayesianHistogramParameters parameters;
  parameters.sigma = kSigma;
  BayesianHistogram posterior(Grid(64), parameters);
  size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(posterior.Add({detections[next++ % detections.size()], 0.0}).ok());
  }
  state.counters["cells"] = Grid(64).num_cells();
}

// The same with a weight in every cell, all of which each detection multiplies.
void DenseBayesianUpdate(benchmark::State& state) {
  const So3Grid& grid = Grid(64);
  const auto count = static_cast<Eigen::Index>(grid.num_cells());
  Eigen::Matrix<float, 4, Eigen::Dynamic> representatives(4, count);
  std::vector<So3Grid::Cell> cells;
  grid.CellsAt(0, grid.num_cells(), &cells);
  for (Eigen::Index i = 0; i < count; ++i) {
    representatives.col(i) =
        grid.Representative(cells[static_cast<size_t>(i)]).coeffs().cast<float>();
  }
  Eigen::VectorXf posterior = Eigen::VectorXf::Ones(count);
  const std::vector<Eigen::Quaterniond> detections = Detections();
  const auto cos_cutoff = static_cast<float>(std::cos(1.5 * kSigma));
  constexpr float kOutliers = 0.05F;
  size_t next = 0;
  for (auto _ : state) {
    const Eigen::Vector4f q = detections[next++ % detections.size()].coeffs().cast<float>();
    for (Eigen::Index i = 0; i < count; ++i) {
      const float dot = std::abs(representatives.col(i).dot(q));
      float likelihood = kOutliers;
      if (dot >= cos_cutoff) {
        const float angle = 2.0F * std::acos(std::min(1.0F, dot));
        const auto sigma = static_cast<float>(kSigma);
        likelihood += 0.95F * std::exp(-0.5F * angle * angle / (sigma * sigma));
      }
      posterior[i] *= likelihood / kOutliers;
    }
    benchmark::DoNotOptimize(posterior.data());
    if (next % detections.size() == 0) posterior.setOnes();
  }
}

// One view of 30, update and estimate.
template <class Make>
void View(benchmark::State& state, const Make& make) {
  const std::vector<Eigen::Quaterniond> detections = Detections();
  auto fusion = make();
  size_t next = 0;
  for (auto _ : state) {
    if (next == detections.size()) {
      state.PauseTiming();
      fusion = make();
      next = 0;
      state.ResumeTiming();
    }
    benchmark::DoNotOptimize(fusion->Add({detections[next++], 0.0}).ok());
    benchmark::DoNotOptimize(fusion->Estimate().ok());
  }
}

void HistogramView(benchmark::State& state) {
  OrientationFilterParameters parameters;
  parameters.sigma_cw = kSigma;
  parameters.final_orientation = FinalOrientation::kCwVwClustering;
  View(state, [&] { return std::make_unique<OrientationFilter>(Grid(), parameters); });
}

void DensityModeView(benchmark::State& state) {
  OrientationFilterParameters parameters;
  parameters.sigma_cw = kSigma;
  View(state, [&] { return std::make_unique<OrientationFilter>(Grid(), parameters); });
}

void ParticleFilterView(benchmark::State& state) {
  ParticleFilterParameters parameters;
  parameters.sigma_cw = kSigma;
  View(state, [&] { return std::make_unique<ParticleFilter>(parameters); });
}

void BinghamProductView(benchmark::State& state) {
  BinghamMixtureParameters parameters;
  parameters.sigma = kSigma;
  View(state, [&] { return std::make_unique<BinghamMixtureFilter>(parameters); });
}

void BinghamSmcView(benchmark::State& state) {
  BinghamSmcParameters parameters;
  parameters.sigma = kSigma;
  View(state, [&] { return std::make_unique<BinghamSmcFilter>(parameters, uint64_t{1}); });
}

// 250 trials from each direction of an object with four alike sides.
const ContingencyTable& Table(int k) {
  const auto measured = [](int of_k) {
    SyntheticObject object;
    object.outliers = 0.02;
    return object.Measure(NumDirections(of_k), 250, 1);
  };
  static const ContingencyTable table_8 = measured(8);
  static const ContingencyTable table_32 = measured(32);
  return k == 8 ? table_8 : table_32;
}

std::vector<ConfusionView> ConfusionViews(int count) {
  const SyntheticObject object;
  Rng rng(2);
  const Eigen::Quaterniond truth = rng.Rotation();
  std::vector<ConfusionView> views;
  for (int i = 0; i < count; ++i) {
    const Eigen::Quaterniond camera = rng.Rotation();
    views.push_back({camera, camera * *object.Detect(camera.conjugate() * truth, rng)});
  }
  return views;
}

void AccuracyUpdate(benchmark::State& state) {
  const int k = static_cast<int>(state.range(0));
  AccuracyWeights weights = AccuracyWeights::FromDirections(Table(k), Grid(k)).value();
  OrientationHistogram histogram(Grid(k));
  const std::vector<ConfusionView> views = ConfusionViews(kNumUpdates);
  size_t next = 0;
  for (auto _ : state) {
    const ConfusionView& view = views[next++ % views.size()];
    weights.AddTo(view.q_world_camera, *view.q_world_object, 1.0, &histogram);
  }
  state.counters["cells"] = static_cast<double>(histogram.weights().Entries().size());
}

// The same with every cell's count looked for in its direction's differences.
void DenseAccuracyUpdate(benchmark::State& state) {
  const int k = static_cast<int>(state.range(0));
  const So3Grid& grid = Grid(k);
  const ContingencyTable& table = Table(k);
  const DirectionGrid directions(NumDirections(k));
  std::vector<std::vector<std::pair<Eigen::Quaterniond, double>>> differences;
  for (const DirectionTrials& direction : table.directions) {
    differences.emplace_back();
    for (const DifferenceCount& one : direction.differences) {
      differences.back().emplace_back(one.Difference(), one.count);
    }
  }
  const std::vector<So3Grid::Cell> cells = grid.ValidCells();
  std::vector<double> weights(cells.size(), 0.0);
  const double least_near = std::cos(1.15 / k);  // Of half the angle across which a cell reaches.
  const std::vector<ConfusionView> views = ConfusionViews(kNumUpdates);
  size_t next = 0;
  for (auto _ : state) {
    const ConfusionView& view = views[next++ % views.size()];
    const Eigen::Quaterniond q_camera_world = view.q_world_camera.conjugate();
    const So3Grid::Cell detected = grid.CellOf(q_camera_world * *view.q_world_object);
    const Eigen::Quaterniond representative = grid.Representative(detected);
    for (size_t i = 0; i < cells.size(); ++i) {
      const Eigen::Quaterniond truth = q_camera_world * grid.Representative(cells[i]);
      const Eigen::Quaterniond wanted = truth.conjugate() * representative;
      const auto direction = static_cast<size_t>(directions.CellOf(ViewingDirection(truth)));
      double count = AccuracyWeights::kPseudoCount;
      for (const auto& [difference, of_difference] : differences[direction]) {
        if (std::abs(difference.dot(wanted)) < least_near) continue;
        if (grid.CellOf(truth * difference) == detected) count += of_difference;
      }
      weights[i] += count;
    }
    benchmark::DoNotOptimize(weights.data());
  }
  state.counters["cells"] = grid.num_cells();
}

void ConfusionModelMake(benchmark::State& state) {
  const ContingencyTable& table = Table(32);
  for (auto _ : state) {
    benchmark::DoNotOptimize(ConfusionModel::Make(table, SymmetryGroup::None()).ok());
  }
}

void ModeBeliefOfTen(benchmark::State& state) {
  const ConfusionModel model = ConfusionModel::Make(Table(32), SymmetryGroup::None()).value();
  const std::vector<ConfusionView> views = ConfusionViews(10);
  for (auto _ : state) benchmark::DoNotOptimize(ModeBelief(model, views));
}

void MakeGrid(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(So3Grid(static_cast<int>(state.range(0))));
}

BENCHMARK(TruncatedUpdate)->Arg(32)->Arg(64)->Unit(benchmark::kMicrosecond);
BENCHMARK(DenseUpdate)->Unit(benchmark::kMicrosecond);
BENCHMARK(FinalOrientationOfThirty)->Unit(benchmark::kMicrosecond);
BENCHMARK(DenseFinalOrientation)->Unit(benchmark::kMicrosecond);
BENCHMARK(AllPeaks)->Unit(benchmark::kMicrosecond);
BENCHMARK(ModeOfThirty)->Unit(benchmark::kMicrosecond);
BENCHMARK(BayesianUpdate)->Unit(benchmark::kMicrosecond);
BENCHMARK(DenseBayesianUpdate)->Unit(benchmark::kMicrosecond);
BENCHMARK(HistogramView)->Unit(benchmark::kMicrosecond);
BENCHMARK(DensityModeView)->Unit(benchmark::kMicrosecond);
BENCHMARK(ParticleFilterView)->Unit(benchmark::kMicrosecond);
BENCHMARK(BinghamProductView)->Unit(benchmark::kMicrosecond);
BENCHMARK(BinghamSmcView)->Unit(benchmark::kMicrosecond);
BENCHMARK(HistogramView)->Name("HistogramView/beside_smc")->Unit(benchmark::kMicrosecond);
BENCHMARK(AccuracyUpdate)->Arg(8)->Arg(32)->Unit(benchmark::kMicrosecond);
BENCHMARK(DenseAccuracyUpdate)->Arg(8)->Arg(32)->Unit(benchmark::kMicrosecond);
BENCHMARK(ConfusionModelMake)->Unit(benchmark::kMillisecond);
BENCHMARK(ModeBeliefOfTen)->Unit(benchmark::kMicrosecond);
BENCHMARK(MakeGrid)->Arg(32)->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vantage

BENCHMARK_MAIN();
