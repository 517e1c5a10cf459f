#include "perception/shot/shot_model.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/depth_rasterizer.h"
#include "perception/segmentation/normals.h"

namespace vantage {
namespace {

// A training view is taken from where an object of this size fills a fair part of the image.
constexpr double kDistance = 0.75;       // m
constexpr double kDistanceShare = 3.75;  // Of the diameter, at least.

// Evenly spread directions (Fibonacci lattice).
Eigen::Vector3d Direction(int index, int count) {
  const double z = 1.0 - (2.0 * index + 1.0) / count;
  const double turn = std::numbers::pi * (3.0 - std::sqrt(5.0)) * index;
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(turn), r * std::sin(turn), z};
}

// A VGA camera's middle, wide enough for the model.
CameraModel TrainingCamera(double diameter, double distance) {
  CameraModel camera;
  const double half = 0.6 * diameter * camera.fx / (distance - 0.5 * diameter);
  camera.width = camera.height = 2 * static_cast<int>(std::ceil(half)) + 1;
  camera.cx = camera.cy = std::ceil(half);
  return camera;
}

// What a camera sees of the model, in the model's coordinates.
std::vector<SurfacePoint> SeenFrom(const ObjectModel& object,
                                   const Eigen::Vector3d& direction,
                                   double spacing,
                                   DepthRasterizer* rasterizer) {
  const CameraModel& camera = rasterizer->camera();
  const double distance = std::max(kDistance, kDistanceShare * object.diameter);
  const Pose T_object_camera = LookAt(object.center + distance * direction, object.center);
  rasterizer->Clear();
  rasterizer->Draw(object.mesh, T_object_camera.inverse());
  DepthImage depth(camera.width, camera.height);
  std::vector<int32_t> labels(depth.depth.size(), -1);
  std::vector<uint32_t> pixels;
  for (uint32_t i = 0; i < depth.depth.size(); ++i) {
    if (rasterizer->depth()[i] == DepthRasterizer::kEmpty) continue;
    depth.depth[i] = rasterizer->depth()[i];
    labels[i] = 0;
    pixels.push_back(i);
  }
  std::vector<SurfacePoint> points =
      SampleSurfaces(depth, camera, labels, pixels, spacing, NormalParameters{});
  for (SurfacePoint& point : points) {
    point.position = T_object_camera.cast<float>() * point.position;
    point.normal = T_object_camera.linear().cast<float>() * point.normal;
  }
  return points;
}

// The directions in which descriptors differ most, one after the other.
std::vector<float> PrincipalComponents(std::span<const ShotFeature> features, int count) {
  Eigen::MatrixXf moments = Eigen::MatrixXf::Zero(kShotSize, kShotSize);
  for (const ShotFeature& feature : features) {
    moments.selfadjointView<Eigen::Lower>().rankUpdate(
        Eigen::Map<const Eigen::VectorXf>(feature.descriptor.data(), kShotSize));
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXf> solver(moments);
  std::vector<float> basis;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::VectorXf component =
        solver.eigenvectors().col(static_cast<Eigen::Index>(kShotSize) - 1 - i);
    basis.insert(basis.end(), component.begin(), component.end());
  }
  return basis;
}

// The nearest of places for each point.
std::vector<uint32_t> NearestKeypoints(std::span<const SurfacePoint> points,
                                       std::span<const uint32_t> keypoints) {
  std::vector<uint32_t> nearest;
  for (const SurfacePoint& point : points) {
    const auto distance = [&](uint32_t keypoint) {
      return (points[keypoint].position - point.position).squaredNorm();
    };
    nearest.push_back(
        *std::min_element(keypoints.begin(), keypoints.end(), [&](uint32_t a, uint32_t b) {
          return distance(a) < distance(b);
        }));
  }
  return nearest;
}

}  // namespace

void SelectKeypoints(std::span<const SurfacePoint> points,
                     double distance,
                     std::vector<uint32_t>* keypoints) {
  keypoints->clear();
  const auto nearest = static_cast<float>(distance * distance);
  for (uint32_t i = 0; i < points.size(); ++i) {
    const bool is_free = std::none_of(keypoints->begin(), keypoints->end(), [&](uint32_t other) {
      return (points[other].position - points[i].position).squaredNorm() < nearest;
    });
    if (is_free) keypoints->push_back(i);
  }
}

Result<ShotModel> ShotModel::Train(const ObjectModel& object, const ShotParameters& parameters) {
  if (Result<void> valid = parameters.Validate(); !valid) return valid.error();
  ShotModel model;
  model.diameter_ = object.diameter;
  model.k_ = parameters.k;
  model.size_ = parameters.descriptor_size;
  const double distance = std::max(kDistance, kDistanceShare * object.diameter);
  DepthRasterizer rasterizer(TrainingCamera(object.diameter, distance));
  ShotFeatures describer;
  std::vector<ShotFeature> features;
  std::vector<uint32_t> keypoints;
  for (int view = 0; view < parameters.training_views; ++view) {
    const std::vector<SurfacePoint> seen = SeenFrom(object,
                                                    Direction(view, parameters.training_views),
                                                    parameters.spacing * object.diameter,
                                                    &rasterizer);
    SelectKeypoints(seen, parameters.keypoint_spacing * object.diameter, &keypoints);
    const std::span<const ShotFeature> described =
        describer.Compute(seen, keypoints, parameters.descriptor_radius * object.diameter);
    features.insert(features.end(), described.begin(), described.end());
  }
  constexpr size_t kFewest = 3;
  if (features.size() < kFewest) {
    return Error{ErrorCode::kInvalidArgument,
                 "model \"" + object.id + "\" has fewer than 3 describable keypoints"};
  }
  for (const ShotFeature& feature : features) model.points_.push_back(feature.point);
  SelectKeypoints(model.points_, parameters.keypoint_spacing * object.diameter, &keypoints);
  model.keypoints_ = NearestKeypoints(model.points_, keypoints);
  model.basis_ =
      InnerProducts(PrincipalComponents(features, parameters.descriptor_size), kShotSize);
  model.SetDescriptors(features);
  return model;
}

void ShotModel::Project(std::span<const ShotFeature> features) {
  raw_.clear();
  for (const ShotFeature& feature : features) {
    raw_.insert(raw_.end(), feature.descriptor.begin(), feature.descriptor.end());
  }
  basis_.Compute(raw_, &projected_);
  reduced_.clear();
  for (size_t i = 0; i < features.size(); ++i) {
    const auto row = projected_.begin() + static_cast<std::ptrdiff_t>(i * basis_.stride());
    reduced_.insert(reduced_.end(), row, row + size_);
  }
}

void ShotModel::SetDescriptors(std::span<const ShotFeature> features) {
  Project(features);
  descriptors_ = InnerProducts(reduced_, static_cast<size_t>(size_));
  half_squares_.clear();
  for (size_t i = 0; i < features.size(); ++i) {
    float sum = 0.0F;
    for (int d = 0; d < size_; ++d) {
      const float value = reduced_[i * static_cast<size_t>(size_) + static_cast<size_t>(d)];
      sum += value * value;
    }
    half_squares_.push_back(0.5F * sum);
  }
}

void ShotModel::Match(std::span<const ShotFeature> target,
                      std::vector<Correspondence>* correspondences) {
  correspondences->clear();
  if (target.empty()) return;
  Project(target);
  descriptors_.Compute(reduced_, &products_);
  for (size_t i = 0; i < target.size(); ++i) {
    const float* products = products_.data() + i * descriptors_.stride();
    best_.clear();
    float worst = -std::numeric_limits<float>::infinity();
    for (uint32_t j = 0; j < points_.size(); ++j) {
      // |a - b|^2 falls as a . b - |b|^2 / 2 rises.
      const float likeness = products[j] - half_squares_[j];
      if (!(likeness > worst)) continue;
      worst = Insert(likeness, j);
    }
    for (const Candidate& candidate : best_) {
      correspondences->push_back(
          {static_cast<uint32_t>(i), target[i].point, points_[candidate.descriptor]});
    }
  }
}

// Into the best, most alike first, one of a keypoint. Gives what the next must surpass.
float ShotModel::Insert(float likeness, uint32_t descriptor) {
  const auto same = std::find_if(best_.begin(), best_.end(), [&](const Candidate& other) {
    return keypoints_[other.descriptor] == keypoints_[descriptor];
  });
  if (same != best_.end()) {
    if (same->likeness >= likeness) return Bar();
    best_.erase(same);
  } else if (best_.size() == static_cast<size_t>(k_)) {
    best_.pop_back();
  }
  const auto place = std::find_if(best_.begin(), best_.end(), [&](const Candidate& other) {
    return other.likeness < likeness;
  });
  best_.insert(place, {likeness, descriptor});
  return Bar();
}

float ShotModel::Bar() const {
  return best_.size() < static_cast<size_t>(k_) ? -std::numeric_limits<float>::infinity()
                                                : best_.back().likeness;
}

}  // namespace vantage
