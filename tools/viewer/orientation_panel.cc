#include "tools/viewer/orientation_panel.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "common/format.h"
#include "tools/support/rgb_canvas.h"
#include "tools/support/sphere_renderer.h"
#include "tools/viewer/fiber_renderer.h"
#include "tools/viewer/orientation_samples.h"
#include "tools/viewer/viewer_scene.h"

namespace vantage {
namespace {

constexpr size_t kMaxSamples = 6'000;  // Drawn: the heaviest.
constexpr size_t kMaxSpots = 4;
constexpr double kSpotRadius = 12.0 * kDegree;
constexpr int kHeadHeight = 22;  // px
constexpr int kFootHeight = 18;  // px

std::string VectorText(const Eigen::Vector3d& v) {
  // (1, 1, 1) is easier to read than its unit vector.
  const Eigen::Vector3d scaled = v / v.cwiseAbs().maxCoeff();
  return Format("(%.3g, %.3g, %.3g)", scaled.x(), scaled.y(), scaled.z());
}

class OrientationPanel {
 public:
  OrientationPanel(const ShownObject& object,
                   std::vector<OrientationSample> samples,
                   const ViewerOptions& options,
                   const PixelBox& box,
                   Page* page)
      : object_(object),
        samples_(std::move(samples)),
        v_(options.vector),
        reference_(object.peaks.front().q_world_object),
        box_(box),
        page_(*page) {
    const Eigen::Vector3d peak = reference_ * v_;
    // A little from above, so that the poles are seen too.
    view_.towards = peak + Eigen::Vector3d(0.0, 0.0, peak.z() < 0.0 ? -0.4 : 0.4);
    const int by_width = (box.width - 3 * TwoHalves::kMargin) / 4;
    const int by_height = static_cast<int>(0.135 * box.height);
    view_.radius_px = std::max(20, std::min(by_width, by_height));
  }

  void Draw() {
    const int left = box_.x + (box_.width - view_.width()) / 2;
    int y = box_.y;
    Head(y,
         Format("Orientation of %d %s: where it takes v = %s",
                object_.instance,
                object_.model_id.c_str(),
                VectorText(v_).c_str()));
    y += kHeadHeight;
    DrawDensity(left, y);
    DrawLegend(left, y, true);
    y += view_.height() + kFootHeight + 8;
    Head(y, "The same by what v hides: the angle about it");
    y += kHeadHeight;
    const auto spots = FindSpots(samples_, v_, reference_, kSpotRadius, kMaxSpots);
    Paste(RenderFibers(samples_, v_, reference_, view_, kPaper), left, y, page_.image);
    for (size_t i = 0; i < spots.size(); ++i) DrawSpotNumber(left, y, spots[i].direction, i);
    DrawLegend(left, y, false);
    y += view_.height() + kFootHeight + 8;
    DrawRings(spots, y);
  }

 private:
  void Head(int y, const std::string& text) {
    page_.texts.push_back(
        {box_.x + 10.0, y + 0.5 * kHeadHeight, text, 14, kInk, TextSide::kLeft, true});
  }

  void DrawDensity(int left, int y) {
    std::vector<SphereSample> places;
    places.reserve(samples_.size());
    for (const OrientationSample& sample : samples_) {
      places.push_back({(sample.q * v_).cast<float>(), static_cast<float>(sample.weight)});
    }
    SphereView view;
    view.radius_px = view_.radius_px;
    view.towards = view_.towards;
    view.background = kPaper;
    Paste(RenderSphereDensity(places, view), left, y, page_.image);
    for (size_t i = 0; i < object_.peaks.size(); ++i) {
      const Eigen::Vector2d at =
          Eigen::Vector2d(left, y) + view_.Project(object_.peaks[i].q_world_object * v_);
      Circle(at, i == 0 ? 9.0 : 6.0, i == 0 ? 2.4 : 1.4, ColorOfInstance(object_.instance));
    }
  }

  // The sides' names in the pictures' corners, and below what the colors mean.
  void DrawLegend(int left, int y, bool is_density) {
    for (const bool is_far : {false, true}) {
      page_.texts.push_back({left + view_.Center(is_far).x() - view_.radius_px,
                             y + 10.0,
                             is_far ? "far side" : "near side",
                             12,
                             kFaintInk});
    }
    const double x = box_.x + 10.0;
    const double middle = y + view_.height() + 0.5 * kFootHeight;
    std::string note = "circles: peaks of OBJECTS, the large one is the estimate";
    double end = 0.0;
    if (is_density) {
      end = DrawScale(x, middle, "no weight", "most", &DensityColor, &page_);
    } else {
      const auto color = [](double t) { return AngleColor((2.0 * t - 1.0) * std::numbers::pi); };
      end = DrawScale(x, middle, "-180", "180 deg from the estimate", color, &page_);
      note = "grey: several angles at one place";
    }
    page_.texts.push_back({end + 18.0, middle, note, 12, kFaintInk});
  }

  void DrawSpotNumber(int left, int y, const Eigen::Vector3d& direction, size_t index) {
    const Eigen::Vector2d at = Eigen::Vector2d(left, y) + view_.Project(direction);
    DrawLine(page_.image, at, at + Eigen::Vector2d(13.0, -13.0), 1.0, kInk);
    page_.texts.push_back({at.x() + 19.0,
                           at.y() - 18.0,
                           Format("%zu", index + 1),
                           13,
                           kInk,
                           TextSide::kCenter,
                           true});
  }

  void DrawRings(const std::vector<FiberSpot>& spots, int y) {
    Head(y, "Circles over the spots: weight by that angle");
    y += kHeadHeight;
    const int height = box_.bottom() - y;
    const double cell = static_cast<double>(box_.width) / kMaxSpots;
    const double outer = std::min(0.5 * cell - 16.0, 0.5 * (height - 44.0));
    if (outer < 12.0) return;
    for (size_t i = 0; i < spots.size(); ++i) {
      const Eigen::Vector2d center(box_.x + (static_cast<double>(i) + 0.5) * cell,
                                   y + 14.0 + outer);
      DrawRing(spots[i], center, outer);
      page_.texts.push_back({center.x(),
                             center.y() + outer + 20.0,
                             Format("spot %zu: %.1f %%", i + 1, 100.0 * spots[i].weight),
                             12,
                             kInk,
                             TextSide::kCenter});
    }
  }

  // Angle 0 is up, and it grows clockwise.
  void DrawRing(const FiberSpot& spot, const Eigen::Vector2d& center, double outer) {
    const double inner = 0.45 * outer;
    const double highest = *std::max_element(spot.bins.begin(), spot.bins.end());
    constexpr double kBin = 2.0 * std::numbers::pi / FiberSpot::kNumBins;
    const auto on = [&](double angle, double radius) -> Eigen::Vector2d {
      return center + radius * Eigen::Vector2d(std::sin(angle), -std::cos(angle));
    };
    Circle(center, outer, 1.0, kRule);
    Circle(center, inner, 1.0, kFaintInk);
    for (size_t i = 0; i < FiberSpot::kNumBins && highest > 0.0; ++i) {
      const double angle = (static_cast<double>(i) + 0.5) * kBin - std::numbers::pi;
      const double length = (outer - inner) * spot.bins[i] / highest;
      if (length < 0.5) continue;
      for (double off = -0.4; off <= 0.4; off += 0.1) {
        DrawLine(page_.image,
                 on(angle + off * kBin, inner + 1.0),
                 on(angle + off * kBin, inner + std::max(2.0, length)),
                 1.4,
                 AngleColor(angle));
      }
    }
    if (inner < 20.0) return;  // No room for words.
    for (const auto& [angle, text] :
         {std::pair{0.0, "0"}, {90.0, "90"}, {180.0, "180"}, {-90.0, "-90"}}) {
      const Eigen::Vector2d at = on(angle * kDegree, 0.62 * inner);
      page_.texts.push_back({at.x(), at.y(), text, 10, kFaintInk, TextSide::kCenter});
    }
  }

  void Circle(const Eigen::Vector2d& center, double radius, double width, Rgb color) {
    constexpr int kParts = 48;
    for (int i = 0; i < kParts; ++i) {
      const double from = 2.0 * std::numbers::pi * i / kParts;
      const double to = 2.0 * std::numbers::pi * (i + 1) / kParts;
      DrawLine(page_.image,
               center + radius * Eigen::Vector2d(std::cos(from), std::sin(from)),
               center + radius * Eigen::Vector2d(std::cos(to), std::sin(to)),
               width,
               color);
    }
  }

  const ShownObject& object_;
  std::vector<OrientationSample> samples_;
  Eigen::Vector3d v_;
  Eigen::Quaterniond reference_;
  PixelBox box_;
  Page& page_;
  TwoHalves view_;
};

}  // namespace

void DrawOrientationPanel(const ViewerState& state,
                          const ViewerOptions& options,
                          const PixelBox& box,
                          Page* page) {
  const ShownObject* object = ChosenObject(state, options);
  const auto histogram = object == nullptr ? nullptr : state.histogram(object->instance);
  std::vector<OrientationSample> samples;
  if (histogram) samples = SamplesOf(*histogram);
  if (samples.empty()) {
    page->texts.push_back({box.x + 10.0,
                           box.y + 0.5 * kHeadHeight,
                           object == nullptr ? "No object yet" : "No ORIENTATION_HISTOGRAM yet",
                           14,
                           kFaintInk,
                           TextSide::kLeft,
                           true});
    return;
  }
  if (samples.size() > kMaxSamples) {
    std::stable_sort(
        samples.begin(), samples.end(), [](const OrientationSample& a, const OrientationSample& b) {
          return a.weight > b.weight;
        });
    samples.resize(kMaxSamples);
  }
  OrientationPanel(*object, std::move(samples), options, box, page).Draw();
}

}  // namespace vantage
