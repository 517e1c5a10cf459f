#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <span>

#include "common/so3.h"
#include "common/triangle_mesh.h"
#include "perception/model/object_model.h"

namespace vantage {

using PclPoints = pcl::PointCloud<pcl::PointXYZ>;
using PclSurface = pcl::PointCloud<pcl::PointNormal>;

/// Only errors that end the program are printed.
void SilencePcl();

/// Samples with normals of what can be seen of the model, `spacing` (of the diameter) apart.
PclSurface::Ptr ModelSurface(const ObjectModel& model, double spacing);

/// The centroids of the points in the cubes of a grid (pcl::VoxelGrid), with normals towards the
/// camera at the origin (pcl::NormalEstimation).
/// @param leaf m, of the grid.
/// @param normal_leaf m, of the finer grid on which the normals are estimated.
/// @param normal_radius m, of the neighborhood of a normal.
PclSurface::Ptr SceneSurface(std::span<const Eigen::Vector3f> points,
                             double leaf,
                             double normal_leaf,
                             double normal_radius);

/// Point-to-plane ICP (pcl::IterativeClosestPointWithNormals) of the scene to the model, so that
/// what the camera doesn't see of the model has no say. @return T_camera_object.
Pose RefineWithIcp(const PclSurface::Ptr& scene,
                   const PclSurface::Ptr& model,
                   const Pose& T_camera_object,
                   double diameter);

}  // namespace vantage
