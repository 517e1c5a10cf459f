#include "tools/evaluate/fusion_methods.h"

#include <cmath>
#include <utility>

#include "common/format.h"
#include "common/so3.h"
#include "fusion/bayesian_histogram.h"
#include "fusion/bingham/bingham_mixture_filter.h"
#include "fusion/bingham/bingham_smc_filter.h"
#include "fusion/compared/knn_clustering.h"
#include "fusion/compared/mean_orientation.h"
#include "fusion/compared/particle_filter.h"
#include "fusion/orientation_filter.h"

namespace vantage {
namespace {

FusionMethod Histogram(const So3Grid& grid,
                       MethodInfo info,
                       const OrientationFilterParameters& parameters,
                       bool is_told_symmetry = false) {
  return {std::move(info),
          [&grid, parameters, is_told_symmetry](uint64_t, const SymmetryGroup& symmetry) {
            OrientationKnowledge knowledge;
            if (is_told_symmetry) knowledge.symmetry = symmetry;
            return std::make_unique<OrientationFilter>(grid, parameters, knowledge);
          }};
}

MethodInfo Ours(std::string id, std::string label, std::string parameters, bool is_past_paper) {
  return {std::move(id), std::move(label), std::move(parameters), true, is_past_paper};
}

void AppendCompared(std::vector<FusionMethod>* methods) {
  methods->push_back(
      {{"mean", "Mean orientation", "chordal mean", false, false},
       [](uint64_t, const SymmetryGroup&) { return std::make_unique<MeanOrientation>(); }});
  const KnnClusteringParameters knn;
  methods->push_back(
      {{"knn",
        "KNN clustering",
        Format("neighbors within %g deg", knn.max_distance / kDegree),
        false,
        false},
       [knn](uint64_t, const SymmetryGroup&) { return std::make_unique<KnnClustering>(knn); }});
  const ParticleFilterParameters particle;
  methods->push_back({{kParticleFilterId,
                       "Particle filter",
                       Format("%d particles, sigma %g deg, outliers %g",
                              particle.num_particles,
                              particle.sigma_cw / kDegree,
                              particle.outlier_share),
                       false,
                       false},
                      [particle](uint64_t seed, const SymmetryGroup&) {
                        ParticleFilterParameters seeded = particle;
                        seeded.seed = seed;
                        return std::make_unique<ParticleFilter>(seeded);
                      }});
  const BinghamMixtureParameters mixture;
  methods->push_back({{"bmm_mr",
                       "BMM M+R",
                       Format("sigma %g deg, uniform component %g",
                              mixture.sigma / kDegree,
                              1.0 - mixture.peaked_weight),
                       false,
                       false},
                      [mixture](uint64_t, const SymmetryGroup&) {
                        return std::make_unique<BinghamMixtureFilter>(mixture);
                      }});
  const BinghamSmcParameters smc;
  methods->push_back({{"bmm_smc",
                       "BMM SMC",
                       Format("%d samples, sigma %g deg, uniform component %g",
                              smc.num_samples,
                              smc.sigma / kDegree,
                              1.0 - smc.peaked_weight),
                       false,
                       false},
                      [smc](uint64_t seed, const SymmetryGroup&) {
                        return std::make_unique<BinghamSmcFilter>(smc, seed);
                      }});
}

OrientationFilterParameters With(FinalOrientation final_orientation) {
  OrientationFilterParameters parameters;
  parameters.final_orientation = final_orientation;
  return parameters;
}

// The paper's variants.
void AppendHistograms(const So3Grid& grid, std::vector<FusionMethod>* methods) {
  const OrientationFilterParameters filter;
  const std::string cells = Format("k = %d", grid.k());
  const std::string clusters = Format("k = %d, sigma_cw %g deg, w_min %g, w_max %g",
                                      grid.k(),
                                      filter.sigma_cw / kDegree,
                                      filter.peaks.w_min,
                                      filter.peaks.w_max);
  const std::string verified = Format(", sigma_vw (%g mm)^2", 1e3 * std::sqrt(filter.sigma_vw));
  const auto append = [&](FinalOrientation final_orientation,
                          const std::string& label,
                          const std::string& parameters) {
    methods->push_back(Histogram(
        grid, Ours(Name(final_orientation), label, parameters, false), With(final_orientation)));
  };
  append(FinalOrientation::kVoting, "Voting", cells);
  append(FinalOrientation::kVwVoting, "VW voting", cells + verified);
  append(FinalOrientation::kCwClustering, "CW clustering", clusters);
  append(FinalOrientation::kCwVwClustering, "CW+VW clustering", clusters + verified);
}

void AppendPastPaper(const So3Grid& grid, std::vector<FusionMethod>* methods) {
  const BayesianHistogramParameters bayesian;
  methods->push_back({Ours("bayesian",
                           "Bayesian histogram",
                           Format("k = %d, sigma %g deg, outliers %g",
                                  grid.k(),
                                  bayesian.sigma / kDegree,
                                  bayesian.outlier_share),
                           true),
                      [&grid, bayesian](uint64_t, const SymmetryGroup&) {
                        return std::make_unique<BayesianHistogram>(grid, bayesian);
                      }});
  OrientationFilterParameters fixed = With(FinalOrientation::kDensityMode);
  fixed.mode.bandwidth = 0.0;
  methods->push_back(Histogram(grid,
                               Ours("density_mode_fixed",
                                    "Density mode, fixed width",
                                    Format("kernels of %g deg", fixed.mode.sigma / kDegree),
                                    true),
                               fixed));
  const OrientationFilterParameters adaptive = With(FinalOrientation::kDensityMode);
  const std::string width = Format("kernels %g times the scatter", adaptive.mode.bandwidth);
  methods->push_back(Histogram(grid, Ours(kBestBlindId, "Density mode", width, true), adaptive));
  methods->push_back(Histogram(
      grid,
      Ours(kBestOursId, "Density mode, symmetry", width + ", told the symmetry group", true),
      adaptive,
      true));
}

}  // namespace

std::vector<FusionMethod> FusionMethods(const So3Grid& grid) {
  std::vector<FusionMethod> methods;
  AppendCompared(&methods);
  AppendHistograms(grid, &methods);
  AppendPastPaper(grid, &methods);
  return methods;
}

}  // namespace vantage
