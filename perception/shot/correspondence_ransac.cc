#include "perception/shot/correspondence_ransac.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "common/simd.h"

namespace vantage {
namespace {

// Below this ratio of height to longest side three points count as on a line.
constexpr float kFlattest = 0.1F;
// An inlier's normals may differ by so many angle tolerances.
constexpr double kInlierAngle = 2.0;
// Triplets drawn with one first correspondence.
constexpr int kDrawsPerFirst = 16;
// Values of a correspondence.
constexpr size_t kColumns = 12;
// Poses nearer than this, and than the inlier distance, are one.
constexpr double kSameAngle = 8.0 * kDegree;

bool HasMoreInliers(const ConsensusPose& a, const ConsensusPose& b) {
  return a.inliers > b.inliers;
}

float AngleBetween(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return std::acos(std::clamp(a.dot(b), -1.0F, 1.0F));
}

bool IsFlat(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
  const Eigen::Vector3f ab = b - a;
  const Eigen::Vector3f ac = c - a;
  const float longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (c - b).squaredNorm()});
  return !(ab.cross(ac).norm() > kFlattest * longest);
}

// Conditions 3 to 5 as far as they concern two of a triplet.
bool PairAgrees(const Correspondence& a, const Correspondence& b, const RansacParameters& limits) {
  const Eigen::Vector3f query = b.query.position - a.query.position;
  const Eigen::Vector3f match = b.match.position - a.match.position;
  const float d_query = query.norm();
  const float d_match = match.norm();
  const auto nearest = static_cast<float>(limits.min_distance);
  if (!(d_query >= nearest) || !(d_match >= nearest)) return false;
  if (!(std::abs(d_query - d_match) <= static_cast<float>(limits.distance_tolerance))) return false;
  const auto agrees = [&limits](float x, float y) {
    return std::abs(x - y) <= static_cast<float>(limits.angle_tolerance);
  };
  const Eigen::Vector3f along_query = query / d_query;
  const Eigen::Vector3f along_match = match / d_match;
  return agrees(AngleBetween(a.query.normal, along_query),
                AngleBetween(a.match.normal, along_match)) &&
         agrees(AngleBetween(b.query.normal, along_query),
                AngleBetween(b.match.normal, along_match)) &&
         agrees(AngleBetween(a.query.normal, b.query.normal),
                AngleBetween(a.match.normal, b.match.normal));
}

// Conditions 2 and 5 as far as they concern all three.
bool TrianglesAgree(const Correspondence& a,
                    const Correspondence& b,
                    const Correspondence& c,
                    const RansacParameters& limits) {
  if (IsFlat(a.query.position, b.query.position, c.query.position) ||
      IsFlat(a.match.position, b.match.position, c.match.position)) {
    return false;
  }
  const auto agrees =
      [&limits](const Correspondence& p, const Correspondence& q, const Correspondence& r) {
        const auto angle =
            [](const SurfacePoint& at, const SurfacePoint& one, const SurfacePoint& two) {
              return AngleBetween((one.position - at.position).normalized(),
                                  (two.position - at.position).normalized());
            };
        return std::abs(angle(p.query, q.query, r.query) - angle(p.match, q.match, r.match)) <=
               static_cast<float>(limits.angle_tolerance);
      };
  return agrees(a, b, c) && agrees(b, c, a) && agrees(c, a, b);
}

}  // namespace

bool MeetsConditions(const std::array<Correspondence, 3>& triplet,
                     const RansacParameters& parameters) {
  const auto& [a, b, c] = triplet;
  return PairAgrees(a, b, parameters) && PairAgrees(a, c, parameters) &&
         PairAgrees(b, c, parameters) && TrianglesAgree(a, b, c, parameters);
}

int RequiredIterations(double chance, double probability, int largest) {
  if (!(chance > 0.0)) return largest;
  if (chance >= 1.0) return 1;
  const double draws = std::ceil(std::log1p(-probability) / std::log1p(-chance));
  return draws < largest ? std::max(static_cast<int>(draws), 1) : largest;
}

Pose AlignMatches(std::span<const Correspondence> pairs, double normal_weight) {
  Eigen::Vector3d query_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d match_mean = Eigen::Vector3d::Zero();
  for (const Correspondence& pair : pairs) {
    query_mean += pair.query.position.cast<double>();
    match_mean += pair.match.position.cast<double>();
  }
  const auto count = static_cast<double>(std::max<size_t>(pairs.size(), 1));
  query_mean /= count;
  match_mean /= count;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Correspondence& pair : pairs) {
    covariance += (pair.query.position.cast<double>() - query_mean) *
                  (pair.match.position.cast<double>() - match_mean).transpose();
    covariance += normal_weight * pair.query.normal.cast<double>() *
                  pair.match.normal.cast<double>().transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  Pose T_query_match = Pose::Identity();
  T_query_match.linear() =
      svd.matrixU() * Eigen::Vector3d(1.0, 1.0, sign).asDiagonal() * svd.matrixV().transpose();
  T_query_match.translation() = query_mean - T_query_match.linear() * match_mean;
  return T_query_match;
}

void CorrespondenceRansac::Spread(std::span<const Correspondence> all) {
  const size_t blocks = (all.size() + kLanes - 1) / kLanes;
  lanes_.assign(blocks * kLanes * kColumns, std::numeric_limits<float>::quiet_NaN());
  is_marked_.resize(blocks * kLanes);
  for (size_t i = 0; i < all.size(); ++i) {
    const Correspondence& pair = all[i];
    const Eigen::Vector3f* const vectors[] = {
        &pair.query.position, &pair.match.position, &pair.query.normal, &pair.match.normal};
    float* block = lanes_.data() + i / kLanes * kLanes * kColumns;
    for (size_t column = 0; column < kColumns; ++column) {
      block[column * kLanes + i % kLanes] = (*vectors[column / 3])(static_cast<int>(column % 3));
    }
  }
}

// Which of the correspondences may meet conditions 3 and 4 with one: without roots, and so some
// more than do.
VANTAGE_SIMD static void FindLikelyPartners(const float* lanes,
                                            size_t num_blocks,
                                            const float* first,
                                            float nearest_squared,
                                            float tolerance_squared,
                                            int32_t* is_likely) {
  for (size_t block = 0; block < num_blocks; ++block) {
    const float* columns = lanes + block * kColumns * kLanes;
    F8 query{};
    F8 match{};
    for (size_t axis = 0; axis < 3; ++axis) {
      F8 p_query;
      F8 p_match;
      std::memcpy(&p_query, columns + axis * kLanes, sizeof(F8));
      std::memcpy(&p_match, columns + (axis + 3) * kLanes, sizeof(F8));
      query += (p_query - first[axis]) * (p_query - first[axis]);
      match += (p_match - first[axis + 3]) * (p_match - first[axis + 3]);
    }
    // |a - b| = |a^2 - b^2| / (a + b), and (a + b)^2 <= 2 (a^2 + b^2).
    const F8 difference = query - match;
    const I8 mask = (query >= nearest_squared) & (match >= nearest_squared) &
                    (difference * difference <= 2.0F * tolerance_squared * (query + match));
    std::memcpy(is_likely + block * kLanes, &mask, sizeof(mask));
  }
}

// All correspondences that may stand beside `first` in a triplet.
void CorrespondenceRansac::FindPartners(std::span<const Correspondence> all, uint32_t first) {
  constexpr float kRounding = 1e-4F;
  const Eigen::Vector3f& query = all[first].query.position;
  const Eigen::Vector3f& match = all[first].match.position;
  const float place[] = {query.x(), query.y(), query.z(), match.x(), match.y(), match.z()};
  const auto nearest = static_cast<float>(parameters_.min_distance);
  const auto tolerance = static_cast<float>(parameters_.distance_tolerance);
  FindLikelyPartners(lanes_.data(),
                     is_marked_.size() / kLanes,
                     place,
                     nearest * nearest * (1.0F - kRounding),
                     tolerance * tolerance * (1.0F + kRounding) + 1e-12F,
                     is_marked_.data());
  partners_.clear();
  for (uint32_t i = 0; i < all.size(); ++i) {
    if (is_marked_[i] != 0 && PairAgrees(all[first], all[i], parameters_)) partners_.push_back(i);
  }
}

VANTAGE_SIMD static void FindInliers(const float* lanes,
                                     size_t num_blocks,
                                     const float* rows,
                                     float nearest_squared,
                                     float cosine,
                                     int32_t* is_inlier) {
  for (size_t block = 0; block < num_blocks; ++block) {
    F8 c[kColumns];
    std::memcpy(c, lanes + block * kColumns * kLanes, sizeof(c));
    F8 squared{};
    F8 agreement{};
    for (size_t axis = 0; axis < 3; ++axis) {
      const float* row = rows + 4 * axis;
      const F8 off = row[0] * c[3] + row[1] * c[4] + row[2] * c[5] + row[3] - c[axis];
      squared += off * off;
      agreement += (row[0] * c[9] + row[1] * c[10] + row[2] * c[11]) * c[6 + axis];
    }
    const I8 mask = (squared <= nearest_squared) & (agreement >= cosine);
    std::memcpy(is_inlier + block * kLanes, &mask, sizeof(mask));
  }
}

// Of each keypoint at most one counts.
int CorrespondenceRansac::Count(std::span<const Correspondence> all, const Pose& T_query_match) {
  const Eigen::Matrix<float, 3, 4, Eigen::RowMajor> rows =
      T_query_match.matrix().topRows<3>().cast<float>();
  const double angle = std::min(kInlierAngle * parameters_.angle_tolerance, 90.0 * kDegree);
  FindInliers(lanes_.data(),
              is_marked_.size() / kLanes,
              rows.data(),
              static_cast<float>(parameters_.inlier_distance * parameters_.inlier_distance),
              static_cast<float>(std::cos(angle)),
              is_marked_.data());
  int count = 0;
  uint32_t last = all.front().keypoint + 1;
  for (size_t i = 0; i < all.size(); ++i) {
    if (is_marked_[i] == 0 || all[i].keypoint == last) continue;
    last = all[i].keypoint;
    ++count;
  }
  return count;
}

// What the last Count found, of each keypoint the pair that lies nearest.
void CorrespondenceRansac::CollectInliers(std::span<const Correspondence> all,
                                          const Pose& T_query_match) {
  const Eigen::Isometry3f T = T_query_match.cast<float>();
  inliers_.clear();
  float best = 0.0F;
  for (size_t i = 0; i < all.size(); ++i) {
    if (is_marked_[i] == 0) continue;
    const float distance = (T * all[i].match.position - all[i].query.position).squaredNorm();
    if (inliers_.empty() || inliers_.back().keypoint != all[i].keypoint) {
      inliers_.push_back(all[i]);
    } else if (distance < best) {
      inliers_.back() = all[i];
    } else {
      continue;
    }
    best = distance;
  }
}

// One of the poses near each other is kept, that of most inliers; of all the best.
void CorrespondenceRansac::Keep(const ConsensusPose& pose) {
  const auto limit = static_cast<size_t>(parameters_.max_hypotheses);
  if (kept_.size() == limit && kept_.back().inliers >= pose.inliers) return;
  const Eigen::Vector3d place = pose.T_query_match * center_;
  const double same_trace = 1.0 + 2.0 * std::cos(kSameAngle);
  const auto is_near = [&](const ConsensusPose& other) {
    return (other.T_query_match * center_ - place).norm() < parameters_.inlier_distance &&
           pose.T_query_match.linear().cwiseProduct(other.T_query_match.linear()).sum() >
               same_trace;
  };
  const auto known = std::find_if(kept_.begin(), kept_.end(), is_near);
  if (known != kept_.end()) {
    if (known->inliers >= pose.inliers) return;
    kept_.erase(known);
  } else if (kept_.size() == limit) {
    kept_.pop_back();
  }
  const auto place_in_order =
      std::find_if(kept_.begin(), kept_.end(), [&pose](const ConsensusPose& other) {
        return other.inliers < pose.inliers;
      });
  kept_.insert(place_in_order, pose);
}

// The motion from its consensus set instead of from three.
void CorrespondenceRansac::Refit(std::span<const Correspondence> all, ConsensusPose* pose) {
  constexpr int kPasses = 2;
  for (int pass = 0; pass < kPasses; ++pass) {
    Count(all, pose->T_query_match);
    CollectInliers(all, pose->T_query_match);
    const double weight = parameters_.min_distance * parameters_.min_distance;
    const Pose T_query_match = AlignMatches(inliers_, weight);
    const int inliers = Count(all, T_query_match);
    if (inliers < pose->inliers) return;
    *pose = {T_query_match, inliers};
  }
}

std::span<const ConsensusPose> CorrespondenceRansac::Run(std::span<const Correspondence> all,
                                                         const RansacParameters& parameters,
                                                         Rng& rng) {
  parameters_ = parameters;
  kept_.clear();
  kept_.reserve(static_cast<size_t>(parameters.max_hypotheses));
  iterations_ = 0;
  if (all.size() < 3) return {};
  center_.setZero();
  for (const Correspondence& pair : all) center_ += pair.match.position.cast<double>();
  center_ /= static_cast<double>(all.size());
  order_.resize(all.size());
  std::iota(order_.begin(), order_.end(), 0U);
  inliers_.reserve(all.size());
  partners_.reserve(all.size());
  Spread(all);
  int required = parameters.max_iterations;
  const double weight = parameters.min_distance * parameters.min_distance;
  for (size_t i = 0; i < order_.size() && iterations_ < required; ++i) {
    std::swap(order_[i], order_[i + rng.Below(static_cast<uint32_t>(order_.size() - i))]);
    const uint32_t first = order_[i];
    FindPartners(all, first);
    iterations_ += kDrawsPerFirst;
    if (partners_.size() < 2) continue;
    const auto choices = static_cast<uint32_t>(partners_.size());
    for (int draw = 0; draw < kDrawsPerFirst; ++draw) {
      const Correspondence& second = all[partners_[rng.Below(choices)]];
      const Correspondence& third = all[partners_[rng.Below(choices)]];
      if (!PairAgrees(second, third, parameters) ||
          !TrianglesAgree(all[first], second, third, parameters)) {
        continue;
      }
      const std::array<Correspondence, 3> triplet = {all[first], second, third};
      ConsensusPose pose{AlignMatches(triplet, weight)};
      pose.inliers = Count(all, pose.T_query_match);
      if (pose.inliers < 3) continue;
      if (kept_.empty() || pose.inliers > kept_.front().inliers) {
        const double share = pose.inliers / static_cast<double>(all.size());
        required = RequiredIterations(
            share * share * share, parameters.probability, parameters.max_iterations);
      }
      Keep(pose);
    }
  }
  for (ConsensusPose& pose : kept_) Refit(all, &pose);
  // By insertion: stable, and without memory of its own.
  for (auto pose = kept_.begin(); pose != kept_.end(); ++pose) {
    std::rotate(std::upper_bound(kept_.begin(), pose, *pose, HasMoreInliers), pose, pose + 1);
  }
  return kept_;
}

}  // namespace vantage
