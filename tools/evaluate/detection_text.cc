#include "tools/evaluate/detection_text.h"

#include <array>
#include <charconv>
#include <cmath>

#include "common/format.h"
#include "tools/support/hash.h"

namespace vantage {
namespace {

constexpr std::string_view kEndLine = "\nend ";
constexpr std::string_view kEnd = kEndLine.substr(1);
constexpr std::string_view kNextSequence = "\nsequence ";
constexpr std::string_view kSequence = kNextSequence.substr(1);
constexpr int kMaxViews = 1000;
constexpr double kRotationTolerance = 1e-9;
constexpr double kFarthest = 1e6;  // m

template <class Number>
void AppendNumber(Number value, std::string* text) {
  std::array<char, 32> digits{};
  *text += ' ';
  text->append(digits.data(),
               std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
}

void AppendPose(const Pose& pose, std::string* text) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) AppendNumber(pose(row, column), text);
  }
}

std::string EndLine(std::string_view content) {
  return Format("end %016jx\n", static_cast<uintmax_t>(Fnv1a(content)));
}

// Takes words off the front of one line. After something that is not there nothing is any more.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}

  void Expect(std::string_view word) {
    is_sound_ = is_sound_ && rest_.substr(0, word.size()) == word;
    if (is_sound_) rest_.remove_prefix(word.size());
  }
  template <class Number>
  Number Take(Number lowest, Number highest) {
    Expect(" ");
    Number value{};
    if (!is_sound_) return value;
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    is_sound_ = error == std::errc() && value >= lowest && value <= highest;
    if (is_sound_) rest_.remove_prefix(static_cast<size_t>(end - rest_.data()));
    return value;
  }
  Pose TakePose() {
    Pose pose = Pose::Identity();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) pose(row, column) = Take(-kFarthest, kFarthest);
    }
    const Eigen::Matrix3d R = pose.linear();
    is_sound_ =
        is_sound_ && R.determinant() > 0.0 && (R * R.transpose()).isIdentity(kRotationTolerance);
    return pose;
  }
  /// True when all was there, as expected, and nothing else.
  [[nodiscard]] bool Done() const { return is_sound_ && rest_.empty(); }

 private:
  std::string_view rest_;
  bool is_sound_ = true;
};

// Takes the first line, without its end.
std::string_view TakeLine(std::string_view* text) {
  const size_t end = text->find('\n');
  const std::string_view line = text->substr(0, end);
  text->remove_prefix(end == std::string_view::npos ? text->size() : end + 1);
  return line;
}

bool ParseFound(std::string_view line, DetectedView* view) {
  Words words(line);
  Detection detection;
  words.Expect("found");
  detection.cluster = words.Take(0, 1'000'000);
  detection.T_camera_object = words.TakePose();
  detection.mse = words.Take(0.0, 1.0);
  detection.inlier_fraction = words.Take(0.0, 1.0);
  detection.verification_score = words.Take(0.0, 1.0);
  view->detections.push_back(std::move(detection));
  return words.Done();
}

}  // namespace

void AppendSequenceText(const DetectionSequence& sequence, std::string* text) {
  const size_t begin = text->size();
  *text += "sequence";
  AppendNumber(sequence.index, text);
  AppendNumber(sequence.views.size(), text);
  AppendPose(sequence.T_world_object, text);
  *text += '\n';
  for (const DetectedView& view : sequence.views) {
    *text += "view";
    AppendPose(view.T_world_camera, text);
    *text += '\n';
    for (const Detection& detection : view.detections) {
      *text += "found";
      AppendNumber(detection.cluster, text);
      AppendPose(detection.T_camera_object, text);
      AppendNumber(detection.mse, text);
      AppendNumber(detection.inlier_fraction, text);
      AppendNumber(detection.verification_score, text);
      *text += '\n';
    }
  }
  *text += EndLine(std::string_view(*text).substr(begin));
}

SequenceText FirstSequenceText(std::string_view text) {
  const size_t end = text.find(kEndLine);
  if (end != std::string_view::npos && text.substr(0, kSequence.size()) == kSequence) {
    const std::string_view content = text.substr(0, end + 1);
    const std::string end_line = EndLine(content);
    if (text.substr(content.size(), end_line.size()) == end_line) {
      return {text.substr(0, content.size() + end_line.size()), true};
    }
  }
  const size_t next = text.find(kNextSequence);
  return {text.substr(0, next == std::string_view::npos ? text.size() : next + 1), false};
}

Result<DetectionSequence> ParseSequenceText(std::string_view record, size_t* line_number) {
  const auto refuse = [](const char* expected) {
    return Error{ErrorCode::kCorrupt, Format("is not %s", expected)};
  };
  *line_number = 0;
  DetectionSequence sequence;
  Words head(TakeLine(&record));
  head.Expect("sequence");
  sequence.index = head.Take(0, 1'000'000'000);
  const int num_views = head.Take(1, kMaxViews);
  sequence.T_world_object = head.TakePose();
  if (!head.Done()) return refuse("\"sequence\", its index, its number of views and a pose");
  for (++*line_number; record.substr(0, kEnd.size()) != kEnd; ++*line_number) {
    const std::string_view line = TakeLine(&record);
    if (line.substr(0, 4) == "view") {
      DetectedView view;
      Words words(line);
      words.Expect("view");
      view.T_world_camera = words.TakePose();
      if (!words.Done()) return refuse("\"view\" and a pose");
      sequence.views.push_back(std::move(view));
    } else if (sequence.views.empty() || !ParseFound(line, &sequence.views.back())) {
      return refuse("\"found\" after a view, a cluster, a pose and three numbers from 0 to 1");
    }
  }
  TakeLine(&record);
  if (!record.empty()) return refuse("the last line");
  if (sequence.views.size() != static_cast<size_t>(num_views)) {
    return Error{ErrorCode::kCorrupt,
                 Format("comes after %zu views, expected %d", sequence.views.size(), num_views)};
  }
  return sequence;
}

}  // namespace vantage
