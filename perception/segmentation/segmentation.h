#pragma once

#include <cstdint>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/depth_rasterizer.h"
#include "common/result.h"
#include "common/rng.h"
#include "perception/depth_noise.h"
#include "perception/segmentation/support_plane.h"

namespace vantage {

struct SegmentationParameters {
  enum class Support {
    kAuto,  ///< Removes a large plane and what lies below it, if there is one.
    kNone,  ///< All valid points are of objects: images that are segmented already.
  };
  Support support = Support::kAuto;
  SupportPlaneParameters plane;
  double min_depth = 0.2;      ///< m; nearer points are noise of the sensor
  double max_depth = 3.0;      ///< m; farther points are background
  double min_height = 0.005;   ///< m above the plane; at least 3 sigmas of noise are kept clear
  double max_height = 0.5;     ///< m above the plane
  double hull_margin = 0.02;   ///< m outside the plane's hull where objects may still be
  double largest_gap = 0.012;  ///< m between neighbors of one cluster, beyond their spacing
  int gap_px = 2;              ///< px that missing data may bridge
  int min_points = 200;        ///< px; smaller clusters are dropped
  DepthNoise noise;
  Result<void> Validate() const;
};

/// Pixels that may be one object: a connected cluster, or a part of one.
struct Cluster {
  std::vector<uint32_t> pixels;  ///< Indices into the image, ascending.
  PixelWindow window;            ///< Smallest that holds them.
  bool touches_border = false;   ///< The object may reach out of the image.
  int parent = -1;               ///< Index of the cluster that this is a part of; -1: it is whole.
  int32_t first_label = 0;       ///< Its pixels carry the labels first_label ... last_label,
  int32_t last_label = 0;        ///< and no others do.

  /// True when a pixel of this label (Segmentation::labels) belongs to the cluster.
  [[nodiscard]] bool Holds(int32_t label) const {
    return label >= first_label && label <= last_label;
  }
};

/// What an image falls into. Objects that touch make one connected cluster; where its surface is
/// concave it has parts, which share out all of its pixels, as alternatives to it.
struct Segmentation {
  static constexpr int32_t kNoCluster = -1;

  std::vector<SupportPlane> planes;  ///< Most points first; walls too.
  /// Connected clusters, largest first, equal ones by their first pixel; each is followed by its
  /// parts, of which there are none or more than one, in the same order.
  std::vector<Cluster> clusters;
  /// Per pixel: of the smallest segment that holds it, or kNoCluster. Parts of a cluster have
  /// consecutive labels, so that Cluster::Holds tells what belongs to either.
  std::vector<int32_t> labels;
};

/// Finds clusters of points above support planes, or of all points when there is none. Owns its
/// buffers and its result: allocates nothing once warm.
class Segmenter {
 public:
  explicit Segmenter(const SegmentationParameters& parameters) : parameters_(parameters) {}

  /// Valid until the next call. The same for equal input and state of `rng`.
  /// @param depth of the camera's width and height; the camera is valid.
  const Segmentation& Segment(const DepthImage& depth, const CameraModel& camera, Rng& rng);

 private:
  SegmentationParameters parameters_;
  Segmentation result_;
};

/// The same of one image alone.
Segmentation Segment(const DepthImage& depth,
                     const CameraModel& camera,
                     const SegmentationParameters& parameters,
                     Rng& rng);

}  // namespace vantage
