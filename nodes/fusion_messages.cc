#include "nodes/fusion_messages.h"

#include <algorithm>
#include <vector>

namespace vantage {
namespace {

void CopyTranslation(const Eigen::Vector3d& translation, double* trans) {
  for (Eigen::Index i = 0; i < 3; ++i) trans[i] = translation[i];
}

void CopyQuaternion(const Eigen::Quaterniond& q, double* quat) {
  quat[0] = q.w();
  quat[1] = q.x();
  quat[2] = q.y();
  quat[3] = q.z();
}

template <class Matrix>
void CopyRowMajor(const Matrix& matrix, double* values) {
  constexpr Eigen::Index kColumns = Matrix::ColsAtCompileTime;
  for (Eigen::Index i = 0; i < Matrix::SizeAtCompileTime; ++i) {
    values[i] = matrix(i / kColumns, i % kColumns);
  }
}

void CopyRefinedPose(const Pose& T_world_object, object_estimate_v3_t* message) {
  CopyTranslation(T_world_object.translation(), message->refined_trans);
  CopyQuaternion(Canonical(Eigen::Quaterniond(T_world_object.linear())), message->refined_quat);
}

int8_t StateToMessage(ObjectEstimate::State state) {
  switch (state) {
    case ObjectEstimate::State::kConfirmed:
      return object_estimate_v3_t::CONFIRMED;
    case ObjectEstimate::State::kLost:
      return object_estimate_v3_t::LOST;
    case ObjectEstimate::State::kTentative:
      break;
  }
  return object_estimate_v3_t::TENTATIVE;
}

object_estimate_v3_t ObjectToMessage(const ObjectEstimate& object) {
  object_estimate_v3_t message{};
  message.instance_id = object.instance_id;
  message.model_id = object.model_id;
  message.state = StateToMessage(object.state);
  CopyTranslation(object.T_world_object.translation(), message.trans);
  CopyRowMajor(object.center_covariance, message.trans_covariance);
  for (const OrientationPeak& peak : object.peaks) {
    orientation_peak_v2_t peak_message{};
    CopyQuaternion(peak.q, peak_message.quat);
    peak_message.weight = peak.weight;
    peak_message.spread = peak.spread;
    CopyRowMajor(peak.covariance, peak_message.covariance);
    message.peaks.push_back(peak_message);
  }
  message.num_peaks = static_cast<int32_t>(message.peaks.size());
  message.entropy = object.entropy;
  message.num_views = static_cast<int32_t>(object.observations.size());
  message.converged = object.converged ? 1 : 0;
  message.last_change = object.last_change;
  for (const Observation& observation : object.observations) {
    detection_source_t source{};
    source.channel = observation.source.channel;
    source.seq = observation.source.seq;
    source.index = observation.index;
    source.viewpoint = observation.viewpoint;
    message.sources.push_back(source);
  }
  message.num_sources = static_cast<int32_t>(message.sources.size());
  message.refinement = object_estimate_v3_t::NOT_REFINED;
  CopyRefinedPose(object.T_world_object, &message);
  return message;
}

}  // namespace

object_estimates_v3_t ObjectsToMessage(std::span<const ObjectEstimate> objects) {
  object_estimates_v3_t message{};
  for (const ObjectEstimate& object : objects) message.objects.push_back(ObjectToMessage(object));
  message.num_objects = static_cast<int32_t>(message.objects.size());
  return message;
}

void AddRefinement(const MultiViewRefined& refined, object_estimate_v3_t* message) {
  message->refinement =
      refined.is_refined ? object_estimate_v3_t::REFINED : object_estimate_v3_t::REFINEMENT_REFUSED;
  message->refinement_note = refined.note;
  if (!refined.is_refined) return;
  CopyRefinedPose(refined.T_world_object, message);
  CopyRowMajor(refined.covariance, message->refined_covariance);
  message->refined_rms = refined.rms;
  message->refined_views = refined.views;
}

orientation_histogram_t HistogramToMessage(const ObjectEstimate& object) {
  using Entry = CellWeights::Entry;
  orientation_histogram_t message{};
  message.instance_id = object.instance_id;
  message.model_id = object.model_id;
  message.k = object.histogram->grid().k();
  std::vector<Entry> entries = object.histogram->weights().Entries();
  if (entries.size() > kMostCells) {
    const auto last = entries.begin() + static_cast<std::ptrdiff_t>(kMostCells);
    std::nth_element(entries.begin(), last, entries.end(), [](const Entry& a, const Entry& b) {
      return a.weight > b.weight || (a.weight == b.weight && a.cell < b.cell);
    });
    entries.resize(kMostCells);
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
      return a.cell < b.cell;
    });
  }
  for (const Entry& entry : entries) {
    message.cell.push_back(entry.cell);
    message.weight.push_back(entry.weight);
  }
  message.num_cells = static_cast<int32_t>(message.cell.size());
  return message;
}

next_view_t NextViewToMessage(const NextView& view) {
  next_view_t message{};
  message.criterion = view.criterion;
  message.selected = view.selected;
  message.reason = view.reason;
  for (const JudgedView& judged : view.candidates) {
    view_candidate_t candidate{};
    CopyTranslation(judged.T_world_camera.translation(), candidate.trans);
    CopyQuaternion(Canonical(Eigen::Quaterniond(judged.T_world_camera.linear())), candidate.quat);
    candidate.gain = judged.gain;
    candidate.cost = judged.cost;
    candidate.reachable = judged.reachable ? 1 : 0;
    candidate.reason = judged.reason;
    message.candidates.push_back(candidate);
  }
  message.num_candidates = static_cast<int32_t>(message.candidates.size());
  return message;
}

}  // namespace vantage
