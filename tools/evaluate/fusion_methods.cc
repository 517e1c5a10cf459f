#include "tools/evaluate/fusion_methods.h"

#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "common/so3.h"
#include "fusion/bayesian_histogram.h"
#include "fusion/bingham/bingham_mixture_filter.h"
#include "fusion/bingham/bingham_smc_filter.h"
#include "fusion/compared/knn_clustering.h"
#include "fusion/compared/mean_orientation.h"
#include "fusion/compared/particle_filter.h"
#include "fusion/orientation_filter.h"

// The value of a parameter is what `vantage-evaluate --tune` found best for its method among the
// candidates beside it, on sequences that the evaluation does not use.

namespace vantage {
namespace {

using Values = std::vector<double>;

TunableMethod Mean() {
  return {{"mean", "Mean orientation", "chordal mean", false, false},
          false,
          {},
          [](const Values&) -> FusionMaker {
            return
                [](uint64_t, const SymmetryGroup&) { return std::make_unique<MeanOrientation>(); };
          }};
}

TunableMethod Knn() {
  return {{"knn", "KNN clustering", "", false, false},
          false,
          {{"neighbors within", "deg", 0.5, {0.5, 0.7, 1, 1.5, 2, 3, 4, 6, 10, 15, 20}}},
          [](const Values& values) -> FusionMaker {
            KnnClusteringParameters parameters;
            parameters.max_distance = values[0] * kDegree;
            return [parameters](uint64_t, const SymmetryGroup&) {
              return std::make_unique<KnnClustering>(parameters);
            };
          }};
}

TunableMethod Particles() {
  return {{kParticleFilterId, "Particle filter", "548496 particles", false, false},
          true,
          {{"sigma", "deg", 2.0, {0.25, 0.5, 1, 2, 4}},
           {"jitter", "sigma", 0.25, {0.06, 0.125, 0.25, 0.5}},
           {"outliers", "", 0.05, {0.02, 0.05, 0.1, 0.2, 0.4}}},
          [](const Values& values) -> FusionMaker {
            ParticleFilterParameters parameters;
            parameters.num_particles = 548496;
            parameters.sigma_cw = values[0] * kDegree;
            parameters.jitter = values[1] * parameters.sigma_cw;
            parameters.outlier_share = values[2];
            return [parameters](uint64_t seed, const SymmetryGroup&) {
              ParticleFilterParameters seeded = parameters;
              seeded.seed = seed;
              return std::make_unique<ParticleFilter>(seeded);
            };
          }};
}

TunableMethod BinghamMixtures() {
  return {{"bmm_mr", "BMM M+R", "", false, false},
          true,
          {{"sigma", "deg", 1.0, {0.1, 0.15, 0.25, 0.35, 0.5, 0.7, 1, 2, 4}},
           {"uniform component", "", 0.4, {0.01, 0.02, 0.05, 0.1, 0.2, 0.4}}},
          [](const Values& values) -> FusionMaker {
            BinghamMixtureParameters parameters;
            parameters.sigma = values[0] * kDegree;
            parameters.peaked_weight = 1.0 - values[1];
            return [parameters](uint64_t, const SymmetryGroup&) {
              return std::make_unique<BinghamMixtureFilter>(parameters);
            };
          }};
}

TunableMethod BinghamParticles() {
  return {{"bmm_smc", "BMM SMC", "100000 samples", false, false},
          true,
          {{"sigma", "deg", 0.7, {0.2, 0.35, 0.5, 0.7, 1, 2, 4}},
           {"jitter", "sigma", 0.4, {0.1, 0.2, 0.4, 0.8}},
           {"uniform component", "", 0.4, {0.02, 0.05, 0.1, 0.2, 0.4}}},
          [](const Values& values) -> FusionMaker {
            BinghamSmcParameters parameters;
            parameters.num_samples = 100000;
            parameters.sigma = values[0] * kDegree;
            parameters.jitter = values[1];
            parameters.peaked_weight = 1.0 - values[2];
            return [parameters](uint64_t seed, const SymmetryGroup&) {
              return std::make_unique<BinghamSmcFilter>(parameters, seed);
            };
          }};
}

/// How a histogram variant takes its values.
using SetValues = void (*)(const Values& values, OrientationFilterParameters* parameters);

struct HistogramVariant {
  const char* id;
  const char* label;
  FinalOrientation final_orientation;
  bool is_past_paper = false;
  bool is_told_symmetry = false;
};

TunableMethod Histogram(const So3Grid& grid,
                        const HistogramVariant& variant,
                        std::vector<MethodParameter> parameters,
                        SetValues set_values) {
  std::string fixed = Format("k = %d", grid.k());
  if (variant.final_orientation == FinalOrientation::kCwClustering ||
      variant.final_orientation == FinalOrientation::kCwVwClustering) {
    fixed += ", w_min 0.7, w_max 0.9";
  }
  if (variant.is_told_symmetry) fixed += ", told the symmetry group";
  return {{variant.id, variant.label, std::move(fixed), true, variant.is_past_paper},
          false,
          std::move(parameters),
          [&grid, variant, set_values](const Values& values) -> FusionMaker {
            OrientationFilterParameters set;
            set.final_orientation = variant.final_orientation;
            set.peaks.w_min = 0.7;
            set.peaks.w_max = 0.9;
            // Lower modes than C_max are of use to the density mode alone.
            if (set.final_orientation != FinalOrientation::kDensityMode) {
              set.peaks.w_mode = set.peaks.w_max;
            }
            set_values(values, &set);
            const bool is_told_symmetry = variant.is_told_symmetry;
            return [&grid, set, is_told_symmetry](uint64_t, const SymmetryGroup& symmetry) {
              OrientationKnowledge knowledge;
              if (is_told_symmetry) knowledge.symmetry = symmetry;
              return std::make_unique<OrientationFilter>(grid, set, knowledge);
            };
          }};
}

MethodParameter SigmaCw(double value) {
  return {"sigma_cw", "deg", value, {1, 1.5, 2, 3, 4, 6, 8, 12}};
}
MethodParameter SigmaVw(double value) {
  return {"sigma_vw", "mm^2", value, {0.4, 0.8, 1.6, 3, 6, 12, 25}};
}

void SetSigmaCw(double value_deg, OrientationFilterParameters* parameters) {
  parameters->sigma_cw = value_deg * kDegree;
}
void SetSigmaVw(double value_mm2, OrientationFilterParameters* parameters) {
  parameters->sigma_vw = 1e-6 * value_mm2;
}

// The best of both clusterings.
constexpr double kClusteringSigmaCwDeg = 12.0;
constexpr double kClusteringSigmaVwMm2 = 0.8;

// The paper's variants.
void AppendHistograms(const So3Grid& grid, std::vector<TunableMethod>* methods) {
  methods->push_back(Histogram(grid,
                               {"voting", "Voting", FinalOrientation::kVoting},
                               {},
                               [](const Values&, OrientationFilterParameters*) {}));
  methods->push_back(Histogram(grid,
                               {"vw_voting", "VW voting", FinalOrientation::kVwVoting},
                               {SigmaVw(6.0)},
                               [](const Values& values, OrientationFilterParameters* parameters) {
                                 SetSigmaVw(values[0], parameters);
                               }));
  methods->push_back(Histogram(grid,
                               {"cw_clustering", "CW clustering", FinalOrientation::kCwClustering},
                               {SigmaCw(kClusteringSigmaCwDeg)},
                               [](const Values& values, OrientationFilterParameters* parameters) {
                                 SetSigmaCw(values[0], parameters);
                               }));
  methods->push_back(
      Histogram(grid,
                {"cw_vw_clustering", "CW+VW clustering", FinalOrientation::kCwVwClustering},
                {SigmaCw(kClusteringSigmaCwDeg), SigmaVw(kClusteringSigmaVwMm2)},
                [](const Values& values, OrientationFilterParameters* parameters) {
                  SetSigmaCw(values[0], parameters);
                  SetSigmaVw(values[1], parameters);
                }));
}

TunableMethod Bayesian(const So3Grid& grid) {
  return {{"bayesian", "Bayesian histogram", Format("k = %d", grid.k()), true, true},
          false,
          {{"sigma", "deg", 8.0, {1, 1.5, 2, 3, 4, 6, 8}},
           {"outliers", "", 0.4, {0.02, 0.05, 0.1, 0.2, 0.4}}},
          [&grid](const Values& values) -> FusionMaker {
            BayesianHistogramParameters parameters;
            parameters.sigma = values[0] * kDegree;
            parameters.outlier_share = values[1];
            parameters.peaks.w_mode = parameters.peaks.w_max;
            return [&grid, parameters](uint64_t, const SymmetryGroup&) {
              return std::make_unique<BayesianHistogram>(grid, parameters);
            };
          }};
}

// The histogram finds the mode, kernels about the detections themselves refine it.
// With vantage-fusion's own values, which tuning bettered by 5 % at most (docs/evaluation.md).
TunableMethod DensityModeOf(const So3Grid& grid, const HistogramVariant& variant) {
  return Histogram(grid,
                   variant,
                   {{"kernels", "times the scatter", 3.0, {1, 1.5, 2, 3, 4, 6}},
                    {"mse_floor", "mm^2", 0.1, {0.01, 0.03, 0.1, 0.3, 1, 3}},
                    {"sigma", "deg", 4.0, {1, 2, 3, 4, 6, 8}}},
                   [](const Values& values, OrientationFilterParameters* parameters) {
                     parameters->mode.bandwidth = values[0];
                     parameters->mode.mse_floor = 1e-6 * values[1];
                     SetSigmaCw(values[2], parameters);
                     parameters->mode.sigma = parameters->sigma_cw;
                   });
}

void AppendPastPaper(const So3Grid& grid, std::vector<TunableMethod>* methods) {
  methods->push_back(Bayesian(grid));
  methods->push_back(Histogram(
      grid,
      {"density_mode_fixed", "Density mode, fixed width", FinalOrientation::kDensityMode, true},
      {{"kernels", "deg", 1.0, {0.25, 0.35, 0.5, 0.7, 1, 2, 4}}},
      [](const Values& values, OrientationFilterParameters* parameters) {
        parameters->mode.bandwidth = 0.0;
        parameters->mode.sigma = values[0] * kDegree;
        parameters->mode.smallest_sigma = parameters->mode.sigma;
      }));
  methods->push_back(
      DensityModeOf(grid, {kBestBlindId, "Density mode", FinalOrientation::kDensityMode, true}));
  methods->push_back(DensityModeOf(
      grid, {kBestOursId, "Density mode, symmetry", FinalOrientation::kDensityMode, true, true}));
}

}  // namespace

OrientationFilterParameters ClusteringParameters() {
  OrientationFilterParameters parameters;
  SetSigmaCw(kClusteringSigmaCwDeg, &parameters);
  SetSigmaVw(kClusteringSigmaVwMm2, &parameters);
  return parameters;
}

std::vector<double> TunableMethod::Values() const {
  std::vector<double> values;
  for (const MethodParameter& parameter : parameters) values.push_back(parameter.value);
  return values;
}

FusionMethod TunableMethod::With(const std::vector<double>& values) const {
  VANTAGE_CHECK(values.size() == parameters.size(), info.id);
  FusionMethod method{info, is_slow, make(values)};
  std::string& text = method.info.parameters;
  for (size_t i = 0; i < values.size(); ++i) {
    if (!text.empty()) text += ", ";
    text += Format("%s %g", parameters[i].name.c_str(), values[i]);
    if (!parameters[i].unit.empty()) text += " " + parameters[i].unit;
  }
  return method;
}

std::vector<TunableMethod> TunableMethods(const So3Grid& grid) {
  std::vector<TunableMethod> methods = {
      Mean(), Knn(), Particles(), BinghamMixtures(), BinghamParticles()};
  AppendHistograms(grid, &methods);
  AppendPastPaper(grid, &methods);
  return methods;
}

std::vector<FusionMethod> FusionMethods(const So3Grid& grid) {
  std::vector<FusionMethod> methods;
  for (const TunableMethod& method : TunableMethods(grid)) {
    methods.push_back(method.With(method.Values()));
  }
  return methods;
}

}  // namespace vantage
