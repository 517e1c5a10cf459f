#include "fusion/bingham/bingham_mixture.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/check.h"
#include "common/so3.h"

namespace vantage {
namespace {

double LogSumExp(const std::vector<double>& logs) {
  const double largest = *std::max_element(logs.begin(), logs.end());
  double sum = 0.0;
  for (const double value : logs) sum += std::exp(value - largest);
  return largest + std::log(sum);
}

/// log det of a scatter, by Cholesky decomposition; pivots below rounding count as that.
double LogDeterminant(Eigen::Matrix4d a) {
  constexpr double kSmallestPivot = 1e-17;
  double determinant = 1.0;
  for (Eigen::Index k = 0; k < 4; ++k) {
    const double pivot = std::max(a(k, k), kSmallestPivot);
    determinant *= pivot;
    for (Eigen::Index j = k + 1; j < 4; ++j) {
      const double factor = a(j, k) / pivot;
      for (Eigen::Index i = j; i < 4; ++i) a(i, j) -= factor * a(i, k);
    }
  }
  return std::log(determinant);
}

BinghamComponent Merge(const BinghamComponent& a, const BinghamComponent& b) {
  const double log_weight = LogSumExp({a.log_weight, b.log_weight});
  const double share = std::exp(a.log_weight - log_weight);
  return {log_weight,
          BinghamDistribution::Fit(share * a.distribution.scatter() +
                                   (1.0 - share) * b.distribution.scatter())};
}

/// Merges components until so many are left.
class Reducer {
 public:
  explicit Reducer(std::vector<BinghamComponent> components) : components_(std::move(components)) {
    for (const BinghamComponent& component : components_) {
      log_determinants_.push_back(LogDeterminant(component.distribution.scatter()));
    }
    nearest_.resize(components_.size());
    for (size_t i = 0; i < components_.size(); ++i) FindNearest(i);
  }

  std::vector<BinghamComponent> Run(size_t max_components) && {
    while (components_.size() > max_components) MergeNearest();
    return std::move(components_);
  }

 private:
  struct Nearest {
    size_t index = 0;  ///< below the component's own
    double divergence = std::numeric_limits<double>::infinity();
  };

  double Divergence(size_t i, size_t j) const {
    const Eigen::Matrix4d sum =
        components_[i].distribution.scatter() + components_[j].distribution.scatter();
    return LogDeterminant(0.5 * sum) - 0.5 * (log_determinants_[i] + log_determinants_[j]);
  }

  void FindNearest(size_t i) {
    nearest_[i] = {};
    for (size_t j = 0; j < i; ++j) {
      const double divergence = Divergence(i, j);
      if (divergence < nearest_[i].divergence) nearest_[i] = {j, divergence};
    }
  }

  void MergeNearest() {
    size_t i = 1;
    for (size_t k = 2; k < nearest_.size(); ++k) {
      if (nearest_[k].divergence < nearest_[i].divergence) i = k;
    }
    const size_t j = nearest_[i].index;
    components_[j] = Merge(components_[i], components_[j]);
    log_determinants_[j] = LogDeterminant(components_[j].distribution.scatter());
    const auto place = static_cast<std::ptrdiff_t>(i);
    components_.erase(components_.begin() + place);
    log_determinants_.erase(log_determinants_.begin() + place);
    nearest_.erase(nearest_.begin() + place);
    FindNearest(j);
    for (size_t k = j + 1; k < components_.size(); ++k) {
      Nearest& nearest = nearest_[k];
      if (nearest.index == j || nearest.index == i) {
        FindNearest(k);
        continue;
      }
      if (nearest.index > i) --nearest.index;
      const double divergence = Divergence(k, j);
      if (divergence < nearest.divergence) nearest = {j, divergence};
    }
  }

  std::vector<BinghamComponent> components_;
  std::vector<double> log_determinants_;
  std::vector<Nearest> nearest_;
};

}  // namespace

BinghamMixture::BinghamMixture(std::vector<BinghamComponent> components)
    : components_(std::move(components)) {
  VANTAGE_CHECK(!components_.empty(), "a mixture of nothing");
  Normalize();
}

void BinghamMixture::Normalize() {
  std::vector<double> logs;
  for (const BinghamComponent& component : components_) logs.push_back(component.log_weight);
  const double log_sum = LogSumExp(logs);
  for (BinghamComponent& component : components_) component.log_weight -= log_sum;
}

double BinghamMixture::LogDensity(const Eigen::Quaterniond& q) const {
  std::vector<double> logs;
  for (const BinghamComponent& component : components_) {
    logs.push_back(component.log_weight + component.distribution.LogDensity(q));
  }
  return LogSumExp(logs);
}

Eigen::Quaterniond BinghamMixture::Mode() const {
  Eigen::Quaterniond mode = components_.front().distribution.Mode();
  double best = -std::numeric_limits<double>::infinity();
  for (const BinghamComponent& component : components_) {
    const Eigen::Quaterniond q = component.distribution.Mode();
    const double log_density = LogDensity(q);
    if (log_density > best) {
      best = log_density;
      mode = q;
    }
  }
  // Expectation maximization finds modes of mixtures (Carreira-Perpinan 2007): each step is the top
  // of a lower bound that touches the density at the current orientation.
  constexpr int kMaxSteps = 100;
  for (int step = 0; step < kMaxSteps; ++step) {
    const double log_density = LogDensity(mode);
    Eigen::Matrix4d bound = Eigen::Matrix4d::Zero();
    for (const BinghamComponent& component : components_) {
      const double log_share =
          component.log_weight + component.distribution.LogDensity(mode) - log_density;
      bound += std::exp(log_share) * component.distribution.matrix();
    }
    const Eigen::Quaterniond next = BinghamDistribution(bound).Mode();
    const double moved = GeodesicAngle(next, mode);
    mode = next;
    if (moved < 1e-12) break;
  }
  return mode;
}

void BinghamMixture::Reduce(int max_components) {
  VANTAGE_CHECK(max_components >= 1, "a mixture of no components");
  constexpr double kNegligible = -1000.0;
  double heaviest = -std::numeric_limits<double>::infinity();
  for (const BinghamComponent& component : components_) {
    heaviest = std::max(heaviest, component.log_weight);
  }
  std::vector<BinghamComponent> uniform;
  std::vector<BinghamComponent> others;
  for (const BinghamComponent& component : components_) {
    if (component.distribution.is_uniform()) {
      uniform.push_back(component);
    } else if (component.log_weight >= heaviest + kNegligible) {
      others.push_back(component);
    }
  }
  components_ = std::move(uniform);
  const auto limit = static_cast<size_t>(max_components);
  if (others.size() > limit) others = Reducer(std::move(others)).Run(limit);
  components_.insert(components_.end(), others.begin(), others.end());
  Normalize();
}

BinghamMixture Multiply(const BinghamMixture& a, const BinghamMixture& b) {
  std::vector<BinghamComponent> components;
  components.reserve(a.components().size() * b.components().size());
  for (const BinghamComponent& x : a.components()) {
    for (const BinghamComponent& y : b.components()) {
      BinghamProduct product = Multiply(x.distribution, y.distribution);
      components.push_back(
          {x.log_weight + y.log_weight + product.log_weight, std::move(product.distribution)});
    }
  }
  return BinghamMixture(std::move(components));
}

}  // namespace vantage
