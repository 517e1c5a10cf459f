#include "tools/support/stage_text.h"

#include <algorithm>
#include <cstdint>

#include "common/format.h"

namespace vantage {
namespace {

std::string DescribeCluster(const StageTrace& trace, size_t index) {
  const Cluster& cluster = trace.segmentation.clusters[index];
  const std::string part =
      cluster.parent >= 0 ? Format(" (part of cluster %d)", cluster.parent) : std::string();
  const auto num_parts =
      std::ranges::count(trace.segmentation.clusters, static_cast<int>(index), &Cluster::parent);
  return Format("cluster %zu%s: %zu px, %jd parts, %s, %zu points%s\n",
                index,
                part.c_str(),
                cluster.pixels.size(),
                intmax_t{num_parts},
                cluster.touches_border ? "touches the border" : "inside the image",
                trace.clusters[index].num_points,
                trace.clusters[index].models.empty()
                    ? "; not tried: explained already, or too few points"
                    : "");
}

std::string DescribeOutcome(const ModelTrace& model, const VerificationParameters& bounds) {
  switch (model.outcome) {
    case ModelTrace::Outcome::kAccepted:
      return "accepted";
    case ModelTrace::Outcome::kNoProposals:
      return "no proposals";
    case ModelTrace::Outcome::kLowScore:
      return Format("below min_score %.2f", bounds.min_score);
    case ModelTrace::Outcome::kHidden:
      return Format("less than min_visible %.2f of the model is measured", bounds.min_visible);
    case ModelTrace::Outcome::kOtherBetter:
      break;
  }
  return "another pose explains the cluster better";
}

std::string DescribeModel(const StageTrace& trace,
                          const ModelTrace& model,
                          const VerificationParameters& bounds) {
  const std::string& id = trace.models[model.model].object.id;
  const std::string outcome = DescribeOutcome(model, bounds);
  if (model.outcome == ModelTrace::Outcome::kNoProposals) {
    return Format("  %s: %s from %zu points\n", id.c_str(), outcome.c_str(), model.points.size());
  }
  return Format(
      "  %s: %zu proposals from %zu points, best coarse score %.2f, final score %.2f, %s\n",
      id.c_str(),
      model.proposals.size(),
      model.points.size(),
      model.coarse_score,
      model.verification.score(),
      outcome.c_str());
}

}  // namespace

std::string DescribeStages(const StageTrace& trace,
                           const StageImage& image,
                           const VerificationParameters& bounds) {
  std::string text = Format("image %d of %d taken at rest, %jd us, %d x %d px, %zu planes\n",
                            image.number,
                            image.count,
                            intmax_t{image.utime},
                            image.depth.width,
                            image.depth.height,
                            trace.segmentation.planes.size());
  if (trace.clusters.empty()) text += "no cluster: nothing stands out of the support plane\n";
  for (size_t i = 0; i < trace.clusters.size(); ++i) {
    text += DescribeCluster(trace, i);
    for (const ModelTrace& model : trace.clusters[i].models) {
      text += DescribeModel(trace, model, bounds);
    }
  }
  if (trace.detections.empty()) text += "nothing detected\n";
  for (const Detection& detection : trace.detections) {
    text += Format("detected %s in cluster %d, score %.2f\n",
                   detection.model_id.c_str(),
                   detection.cluster,
                   detection.verification_score);
  }
  return text;
}

}  // namespace vantage
