#include "tools/support/stage_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include "common/format.h"
#include "tools/support/depth_view.h"
#include "tools/support/rgb_canvas.h"
#include "tools/support/stage_page.h"
#include "tools/support/stage_pixels.h"

namespace vantage {
namespace {

constexpr int kWidth = StageLayout::kPanelWidth;
constexpr int kHeight = StageLayout::kPanelHeight;
constexpr Rgb kNoDepth = {58, 60, 66};
constexpr Rgb kNoSegment = {112, 114, 120};
constexpr Rgb kPlane = {190, 192, 196};
constexpr Rgb kWhite = {255, 255, 255};
constexpr Rgb kBlack = {0, 0, 0};
constexpr size_t kMostOutlines = 16;

PixelWindow WholeWindow(const CameraModel& camera) {
  return {0, 0, camera.width - 1, camera.height - 1};
}

/// Draws panels of one image.
class StageArtist {
 public:
  StageArtist(const StageTrace& trace,
              const StageImage& image,
              const VerificationParameters& parameters,
              double min_height)
      : trace_(trace), image_(image), parameters_(parameters), min_height_(min_height) {}

  [[nodiscard]] StagePanel Depth() const {
    const DepthView view =
        DrawDepthView(image_.depth, image_.camera, WholeWindow(image_.camera), {}, kWidth, kHeight);
    return {Format("Depth image %d", image_.number),
            view.image,
            {},
            {{DepthColor(0.0), Format("%.2f m", view.near)},
             {DepthColor(0.5), Format("%.2f m", 0.5 * (view.near + view.far))},
             {DepthColor(1.0), Format("%.2f m", view.far)},
             {kNoDepth, "nothing measured"}}};
  }

  [[nodiscard]] StagePanel Segments() const {
    StagePanel panel;
    const CameraModel cut = CutCamera(image_.camera, WholeWindow(image_.camera), kWidth, kHeight);
    panel.image = Paint(cut, [&](int u, int v) { return SegmentColor(u, v); });
    DrawBorders(cut, &panel.image);
    int num_whole = 0;
    for (size_t i = 0; i < trace_.segmentation.clusters.size(); ++i) {
      const Cluster& cluster = trace_.segmentation.clusters[i];
      if (cluster.parent >= 0) continue;
      ++num_whole;
      const PixelWindow& window = cluster.window;
      const Eigen::Vector2d at =
          ToCut(cut, {0.5 * (window.u0 + window.u1), static_cast<double>(window.v0)});
      panel.labels.push_back({std::clamp(at.x(), 40.0, kWidth - 40.0),
                              std::clamp(at.y() - 12.0, 10.0, kHeight - 10.0),
                              Format("%zu", i),
                              kBlack});
    }
    panel.title = Format("Segments: %d %s", num_whole, num_whole == 1 ? "cluster" : "clusters");
    panel.legend = {{{}, "a color each, its parts in shades"},
                    {kNoDepth, "nothing measured"},
                    {kNoSegment, "in no segment"}};
    for (size_t i = 0; i < trace_.segmentation.planes.size(); ++i) {
      panel.legend.push_back({PlaneColor(i), Format("plane %zu", i)});
    }
    return panel;
  }

  [[nodiscard]] StagePanel ScenePoints(size_t cluster, const ModelTrace& model) const {
    const CameraModel cut = CutCamera(image_.camera, Focus(cluster, model), kWidth, kHeight);
    StagePanel panel;
    panel.title = Format("Scene points of cluster %zu", cluster);
    panel.image = Paint(cut, [&](int u, int v) { return PaleColor(u, v); });
    const double length = 0.7 * Spacing(model.points);
    for (const SurfacePoint& point : model.points) {
      const Eigen::Vector3d from = point.position.cast<double>();
      const Eigen::Vector3d normal = point.normal.cast<double>();
      const Eigen::Vector3d to = from + length * normal;
      if (!(from.z() > 0.0) || !(to.z() > 0.0)) continue;
      const Rgb color = NormalColor(normal);
      DrawLine(panel.image, cut.Project(from), cut.Project(to), 1.6, color);
      DrawDisk(panel.image, cut.Project(from), 2.6, color);
    }
    panel.legend = {
        {{},
         Format("%zu points with normals, spaced for %s", model.points.size(), Id(model).c_str())},
        {{}, "color: direction of the normal"}};
    return panel;
  }

  [[nodiscard]] StagePanel Proposals(size_t cluster, const ModelTrace& model) const {
    const size_t count = std::min(model.proposals.size(), kMostOutlines);
    std::vector<OutlinedModel> outlines;
    for (size_t i = count; i-- > 0;) {
      const double rank = static_cast<double>(i) / static_cast<double>(kMostOutlines);
      outlines.push_back({&trace_.models[model.model].object.mesh,
                          model.proposals[i],
                          Mix({196, 40, 20}, {250, 190, 90}, rank),
                          i == 0 ? 1.0 : 0.6 - 0.5 * rank});
    }
    return {
        Format("Poses that the votes propose for %s", Id(model).c_str()),
        DrawDepthView(image_.depth, image_.camera, Focus(cluster, model), outlines, kWidth, kHeight)
            .image,
        {},
        {{Rgb{196, 40, 20}, "the most promising"},
         {Rgb{246, 172, 80}, "the least"},
         {{}, Format("%zu of %zu, not yet refined", count, model.proposals.size())}}};
  }

  [[nodiscard]] StagePanel Verification(size_t cluster, const ModelTrace& model) const {
    const CameraModel cut = CutCamera(image_.camera, Focus(cluster, model), kWidth, kHeight);
    const std::vector<PixelRole> roles =
        FindPixelRoles(trace_.models[model.model].Shape(),
                       model.T_best,
                       {image_.depth, image_.camera, trace_.segmentation},
                       cluster,
                       parameters_);
    StagePanel panel;
    panel.title = Format("Best pose of %s: score %.2f, %s",
                         Id(model).c_str(),
                         model.verification.score(),
                         Verdict(model.outcome).c_str());
    panel.image = Paint(cut, [&](int u, int v) {
      const PixelRole role = roles[image_.depth.Index(u, v)];
      return role == PixelRole::kNone ? PaleColor(u, v)
                                      : Mix(RoleColor(role), PaleColor(u, v), 0.2);
    });
    const vantage::Verification& counts = model.verification;
    const auto note = [](PixelRole role, const char* text, int count) {
      return StagePanel::Note{RoleColor(role), Format("%s %d", text, count)};
    };
    panel.legend = {note(PixelRole::kInlier, "inliers", counts.inliers),
                    note(PixelRole::kSeenThrough, "seen through", counts.seen_through),
                    note(PixelRole::kInFront, "in front", counts.in_front),
                    note(PixelRole::kUnexplained, "unexplained", counts.unexplained),
                    note(PixelRole::kOccluded, "occluded", counts.occluded),
                    note(PixelRole::kEdge, "edge or missing", counts.edge + counts.missing)};
    return panel;
  }

  [[nodiscard]] StagePanel Detections() const {
    std::vector<OutlinedModel> outlines;
    for (const Detection& detection : trace_.detections) {
      // As among the segments, but for the shade of a part.
      const Cluster& cluster = trace_.segmentation.clusters[static_cast<size_t>(detection.cluster)];
      outlines.push_back({&trace_.models[ModelOf(detection)].object.mesh,
                          detection.T_camera_object,
                          ObjectColor(WholeNumber(cluster.first_label))});
    }
    const DepthView view = DrawDepthView(image_.depth, image_.camera, outlines, kWidth, kHeight);
    StagePanel panel;
    panel.title = Format("Detections: %zu", trace_.detections.size());
    panel.image = view.image;
    for (size_t i = 0; i < outlines.size(); ++i) {
      const Detection& detection = trace_.detections[i];
      const PixelWindow& window = view.windows[i];
      if (window.empty()) continue;
      panel.labels.push_back(
          {std::clamp(0.5 * (window.u0 + window.u1), 60.0, kWidth - 60.0),
           std::max(window.v0 - 14.0, 10.0),
           Format("%s %.2f", detection.model_id.c_str(), detection.verification_score),
           Mix(outlines[i].color, kBlack, 0.25)});
    }
    panel.legend = {{{}, "outlines at the refined poses, with the score of the verification"}};
    return panel;
  }

  // In place of a panel that has nothing to show.
  [[nodiscard]] StagePanel Without(const std::string& title, const std::string& reason) const {
    const CameraModel cut = CutCamera(image_.camera, WholeWindow(image_.camera), kWidth, kHeight);
    return {title,
            Paint(cut, [&](int u, int v) { return PaleColor(u, v); }),
            {{0.5 * kWidth, 0.5 * kHeight, reason, kBlack}},
            {}};
  }

 private:
  using ColorAt = std::function<Rgb(int u, int v)>;

  // Every pixel in the color of the image's pixel that it shows.
  [[nodiscard]] RgbImage Paint(const CameraModel& cut, const ColorAt& color_at) const {
    RgbImage picture = FilledImage(cut.width, cut.height, kNoDepth);
    for (int v = 0; v < cut.height; ++v) {
      for (int u = 0; u < cut.width; ++u) {
        const auto [from_u, from_v] = Source(cut, u, v);
        if (image_.depth.Contains(from_u, from_v)) {
          SetPixel(picture, u, v, color_at(from_u, from_v));
        }
      }
    }
    return picture;
  }

  [[nodiscard]] std::pair<int, int> Source(const CameraModel& cut, int u, int v) const {
    const Eigen::Vector2d from = image_.camera.Project(cut.Unproject(u, v, 1.0));
    return {static_cast<int>(std::lround(from.x())), static_cast<int>(std::lround(from.y()))};
  }
  [[nodiscard]] Eigen::Vector2d ToCut(const CameraModel& cut, const Eigen::Vector2d& pixel) const {
    return cut.Project(image_.camera.Unproject(pixel.x(), pixel.y(), 1.0));
  }

  // Background: slopes as shades of pale grey.
  [[nodiscard]] Rgb PaleColor(int u, int v) const {
    const float here = image_.depth.at(u, v);
    if (!std::isfinite(here)) return {206, 208, 212};
    double slope = 0.0;
    if (image_.depth.Contains(u + 2, v + 2) && std::isfinite(image_.depth.at(u + 2, v + 2))) {
      slope = static_cast<double>((image_.depth.at(u + 2, v + 2) - here) / here);
    }
    return Mix({244, 244, 246}, {150, 154, 164}, std::clamp(0.3 + 30.0 * slope, 0.0, 1.0));
  }

  [[nodiscard]] Rgb SegmentColor(int u, int v) const {
    const size_t at = image_.depth.Index(u, v);
    const float depth = image_.depth.depth[at];
    if (!std::isfinite(depth)) return kNoDepth;
    const int32_t label = trace_.segmentation.labels[at];
    if (label != Segmentation::kNoCluster) return ColorOfLabel(label);
    const Eigen::Vector3d p_camera = image_.camera.Unproject(u, v, static_cast<double>(depth));
    for (size_t i = 0; i < trace_.segmentation.planes.size(); ++i) {
      const double height = trace_.segmentation.planes[i].Height(p_camera);
      if (std::abs(height) < 2.0 * min_height_) return PlaneColor(i);
    }
    return kNoSegment;
  }

  static Rgb PlaneColor(size_t plane) {
    return Mix(kPlane, {150, 120, 70}, std::min(0.4 * static_cast<double>(plane), 1.0));
  }

  // Counts the clusters that are no parts before the one of a label.
  [[nodiscard]] size_t WholeNumber(int32_t label) const {
    return static_cast<size_t>(std::ranges::count_if(
        trace_.segmentation.clusters,
        [&](const Cluster& cluster) { return cluster.parent < 0 && cluster.last_label < label; }));
  }

  [[nodiscard]] Rgb ColorOfLabel(int32_t label) const {
    static constexpr std::array<double, 4> kShades = {0.0, 0.55, 0.28, 0.72};
    const auto whole = std::ranges::find_if(
        trace_.segmentation.clusters,
        [&](const Cluster& cluster) { return cluster.parent < 0 && cluster.Holds(label); });
    if (whole == trace_.segmentation.clusters.end()) return kNoSegment;
    const auto part = static_cast<size_t>(label - whole->first_label);
    return Mix(ObjectColor(WholeNumber(label)), kWhite, kShades[part % kShades.size()]);
  }

  // Where the segment changes.
  void DrawBorders(const CameraModel& cut, RgbImage* picture) const {
    const auto label_at = [&](int u, int v) {
      const auto [from_u, from_v] = Source(cut, u, v);
      return image_.depth.Contains(from_u, from_v)
                 ? trace_.segmentation.labels[image_.depth.Index(from_u, from_v)]
                 : Segmentation::kNoCluster;
    };
    for (int v = 0; v + 1 < cut.height; ++v) {
      for (int u = 0; u + 1 < cut.width; ++u) {
        const int32_t here = label_at(u, v);
        if (here != label_at(u + 1, v) || here != label_at(u, v + 1)) {
          SetPixel(*picture, u, v, {40, 42, 48});
        }
      }
    }
  }

  // The cluster and the model in its best pose, with a margin.
  [[nodiscard]] PixelWindow Focus(size_t cluster, const ModelTrace& model) const {
    PixelWindow window = trace_.segmentation.clusters[cluster].window;
    if (model.outcome != ModelTrace::Outcome::kNoProposals) {
      ModelView view;
      const ModelShape shape = trace_.models[model.model].Shape();
      view.Render(shape.mesh,
                  model.T_best,
                  image_.camera,
                  ModelWindow(image_.camera, shape, model.T_best),
                  1);
      view.ForEachPixel([&window](const ModelView::Pixel& pixel) {
        window = {std::min(window.u0, pixel.u),
                  std::min(window.v0, pixel.v),
                  std::max(window.u1, pixel.u),
                  std::max(window.v1, pixel.v)};
      });
    }
    const int margin = 8 + std::max(window.u1 - window.u0, window.v1 - window.v0) / 10;
    return {window.u0 - margin, window.v0 - margin, window.u1 + margin, window.v1 + margin};
  }

  [[nodiscard]] std::string Verdict(ModelTrace::Outcome outcome) const {
    if (outcome == ModelTrace::Outcome::kAccepted) return "accepted";
    if (outcome == ModelTrace::Outcome::kOtherBetter) return "another explains more";
    if (outcome == ModelTrace::Outcome::kHidden) return "too little of it is measured";
    return Format("below %.2f", parameters_.min_score);
  }

  // Median distance of points to their nearest neighbor, m.
  static double Spacing(const std::vector<SurfacePoint>& points) {
    std::vector<float> nearest;
    for (size_t i = 0; i < points.size(); ++i) {
      float least = std::numeric_limits<float>::infinity();
      for (size_t j = 0; j < points.size(); ++j) {
        if (j != i) least = std::min(least, (points[i].position - points[j].position).norm());
      }
      nearest.push_back(least);
    }
    if (nearest.size() < 2) return 0.005;
    std::ranges::sort(nearest);
    return static_cast<double>(nearest[nearest.size() / 2]);
  }

  // To the right red, up green, towards the camera blue.
  static Rgb NormalColor(const Eigen::Vector3d& normal) {
    const auto channel = [](double part) {
      return static_cast<uint8_t>(std::lround(std::clamp(30.0 + 105.0 * (1.0 + part), 0.0, 255.0)));
    };
    return {channel(normal.x()), channel(-normal.y()), channel(-normal.z() - 0.3)};
  }

  static Rgb RoleColor(PixelRole role) {
    switch (role) {
      case PixelRole::kInlier:
        return {62, 160, 92};
      case PixelRole::kSeenThrough:
        return {208, 44, 44};
      case PixelRole::kInFront:
        return {240, 150, 36};
      case PixelRole::kUnexplained:
        return {44, 106, 214};
      case PixelRole::kOccluded:
        return {146, 92, 178};
      case PixelRole::kEdge:
      case PixelRole::kMissing:
      case PixelRole::kNone:
        break;
    }
    return {128, 130, 136};
  }

  [[nodiscard]] const std::string& Id(const ModelTrace& model) const {
    return trace_.models[model.model].object.id;
  }
  [[nodiscard]] size_t ModelOf(const Detection& detection) const {
    const auto model = std::ranges::find_if(trace_.models, [&](const KnownModel& known) {
      return known.object.id == detection.model_id;
    });
    return static_cast<size_t>(model - trace_.models.begin());
  }

  const StageTrace& trace_;
  const StageImage& image_;
  VerificationParameters parameters_;
  double min_height_;  // m, above planes
};

}  // namespace

std::vector<StagePanel> DrawStages(const StageTrace& trace,
                                   const StageImage& image,
                                   const VerificationParameters& parameters,
                                   double min_height,
                                   std::optional<size_t> cluster) {
  const StageArtist artist(trace, image, parameters, min_height);
  std::vector<StagePanel> panels = {artist.Depth(), artist.Segments()};
  const bool was_tried = cluster && !trace.clusters[*cluster].models.empty();
  const ModelTrace* best = was_tried ? BestModel(trace.clusters[*cluster]) : nullptr;
  const std::string reason = cluster ? "not tried" : "no cluster";
  if (was_tried) {
    panels.push_back(artist.ScenePoints(
        *cluster, best != nullptr ? *best : trace.clusters[*cluster].models.front()));
  } else {
    panels.push_back(artist.Without("Scene points", reason));
  }
  if (best != nullptr) {
    panels.push_back(artist.Proposals(*cluster, *best));
    panels.push_back(artist.Verification(*cluster, *best));
  } else {
    const std::string why = was_tried ? "no proposals" : reason;
    panels.push_back(artist.Without("Proposed poses", why));
    panels.push_back(artist.Without("Best pose", why));
  }
  panels.push_back(artist.Detections());
  return panels;
}

}  // namespace vantage
