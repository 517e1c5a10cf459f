#include "planner/view_sequence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "fusion/state_text.h"
#include "planner/farthest_view.h"
#include "planner/information_gain.h"
#include "tests/planner/planner_scenes.h"

namespace vantage {
namespace {

Pose Candidate(const ViewSequence& sequence, int index) {
  return sequence.next_view().candidates[static_cast<size_t>(index)].T_world_camera;
}

// What the tracker would count: sets and viewpoints.
class Camera {
 public:
  explicit Camera(ViewSequence& sequence) : sequence_(sequence) {}

  bool Set(const Pose& T_world_camera) {
    utime_ += 100'000;
    int viewpoint = FindViewpoint(viewpoints_, T_world_camera, {});
    if (viewpoint < 0) {
      viewpoint = static_cast<int>(viewpoints_.size());
      viewpoints_.push_back({T_world_camera, 0});
    }
    ++viewpoints_[static_cast<size_t>(viewpoint)].num_sets;
    return sequence_.OnSet(utime_, T_world_camera, viewpoint, viewpoints_, objects_);
  }

  ViewSequence& sequence_;
  int64_t utime_ = 0;
  std::vector<Viewpoint> viewpoints_;
  std::vector<PlannedObject> objects_;
};

const Pose kStart = LookAt(Eigen::Vector3d(0.0, -0.53, 0.53), Eigen::Vector3d::Zero());

TEST(ViewSequence, DecidesOnceEnoughWasSeenFromAView) {
  ViewSequenceParameters parameters;
  parameters.frames_per_view = 3;
  ViewSequence sequence(parameters, FarthestView());
  Camera camera(sequence);
  EXPECT_EQ(sequence.decision(), -1);
  for (int i = 1; i <= 6; ++i) EXPECT_EQ(camera.Set(kStart), i == 3) << i;
  EXPECT_EQ(sequence.decision(), 300'000);  // The utime of the third set.
  EXPECT_FALSE(sequence.finished());
}

TEST(ViewSequence, NoViewIsSelectedTwiceAndItEndsWhenNoneIsLeft) {
  ViewSequenceParameters parameters;
  parameters.frames_per_view = 1;
  parameters.max_views = 1000;
  ViewSequence sequence(parameters, FarthestView());
  Camera camera(sequence);
  camera.Set(kStart);
  std::set<int> selected;
  while (!sequence.finished()) {
    const int index = sequence.next_view().selected;
    ASSERT_TRUE(selected.insert(index).second);
    camera.Set(Candidate(sequence, index));
  }
  EXPECT_EQ(sequence.next_view().selected, -1);
  // All but the one that the start stands for.
  EXPECT_EQ(selected.size() + 1, MakeViewCandidates(parameters.candidates).size());
}

TEST(ViewSequence, ARobotThatStopsBesideTheViewGetsANewOne) {
  ViewSequenceParameters parameters;
  parameters.frames_per_view = 2;
  ViewSequence sequence(parameters, FarthestView());
  Camera camera(sequence);
  camera.Set(kStart);
  camera.Set(kStart);
  const int first = sequence.next_view().selected;
  sequence.OnArrived(sequence.decision() + 1, camera.utime_);  // Of another decision: nothing.
  EXPECT_FALSE(camera.Set(kStart));
  // It says that it is there, but never left.
  sequence.OnArrived(sequence.decision(), camera.utime_ + 50'000);
  EXPECT_FALSE(camera.Set(kStart));
  EXPECT_TRUE(camera.Set(kStart));
  EXPECT_EQ(sequence.decision(), 200'001);
  EXPECT_NE(sequence.next_view().selected, first);
  EXPECT_EQ(sequence.next_view().candidates[static_cast<size_t>(first)].reason, "visited");
}

// A robot that does not say when it has arrived stops between a visited view and the selected one,
// a little nearer to the latter.
TEST(ViewSequence, WithoutArrivalsTheNearestCandidateIsTheVisitedOne) {
  const auto view = [](double azimuth_deg) {
    const double a = azimuth_deg * kDegree;
    const double e = ViewCandidateParameters().lowest_elevation;
    const Eigen::Vector3d direction(
        std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e));
    return LookAt(0.75 * direction, Eigen::Vector3d::Zero());
  };
  ViewSequence sequence({}, FarthestView());  // Views of a ring are 30 degrees apart.
  Camera camera(sequence);
  camera.Set(view(14.5));
  camera.Set(view(14.5));
  while (sequence.next_view().selected != 1) {  // At 30 degrees.
    ASSERT_TRUE(sequence.OnRefused(sequence.decision(), "too far", camera.viewpoints_, {}));
  }
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(camera.Set(view(14.5)));
  EXPECT_FALSE(camera.Set(view(15.5)));
  EXPECT_TRUE(camera.Set(view(15.5)));
  EXPECT_EQ(camera.viewpoints_.size(), 1U);
  EXPECT_NE(sequence.next_view().selected, 1);
  EXPECT_EQ(sequence.next_view().candidates[1].reason, "visited");
}

// A planner without a saved state is ended and begun anew; the robot goes on saying that it rests
// at the view of a decision of the first life.
TEST(ViewSequence, NumbersOfTwoLivesNeverCoincide) {
  ViewSequence first({}, FarthestView());
  Camera camera(first);
  std::set<int64_t> numbers;
  for (int i = 0; i < 20 && !first.finished(); ++i) {
    camera.Set(i < 2 ? kStart : Candidate(first, first.next_view().selected));
    numbers.insert(first.decision());
  }
  EXPECT_GT(numbers.size(), 5U);

  ViewSequence second({}, FarthestView());
  Camera again(second);
  again.utime_ = camera.utime_;
  again.Set(kStart);
  again.Set(kStart);
  EXPECT_FALSE(numbers.contains(second.decision()));
  const int selected = second.next_view().selected;
  for (const int64_t number : numbers) second.OnArrived(number, again.utime_);
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(again.Set(kStart));
  EXPECT_EQ(second.next_view().selected, selected);
}

TEST(ViewSequence, FinishesWhenAllConfirmedObjectsConverged) {
  ViewSequence sequence({}, FarthestView());
  Camera camera(sequence);
  PlannedObject object;
  object.confirmed = true;
  camera.objects_ = {object, object, object};
  camera.objects_[2].confirmed = false;
  camera.objects_[0].converged = true;
  camera.Set(kStart);
  camera.Set(kStart);
  EXPECT_FALSE(sequence.finished());
  camera.objects_[1].converged = true;
  const Pose next = Candidate(sequence, sequence.next_view().selected);
  camera.Set(next);
  camera.Set(next);
  EXPECT_TRUE(sequence.finished());
  EXPECT_EQ(sequence.next_view().selected, -1);
  EXPECT_NE(sequence.next_view().reason.find("2 confirmed objects converged"), std::string::npos);
}

TEST(ViewSequence, GoesOnFromItsState) {
  ViewSequence sequence({}, FarthestView());
  Camera camera(sequence);
  camera.Set(kStart);
  camera.Set(kStart);
  sequence.OnRefused(sequence.decision(), "out of reach: 1.2 m", camera.viewpoints_, {});
  const std::string text = FormatViewSequenceState(sequence.state());
  StateReader reader(text);
  const ViewSequenceState state = ReadViewSequenceState(reader);
  reader.End();
  ASSERT_FALSE(reader.failed()) << reader.error();
  EXPECT_EQ(FormatViewSequenceState(state), text);

  ViewSequence restored({}, FarthestView());
  ASSERT_TRUE(restored.Restore(state, camera.viewpoints_, {}).ok());
  EXPECT_EQ(restored.decision(), sequence.decision());
  const NextView& a = restored.next_view();
  const NextView& b = sequence.next_view();
  EXPECT_EQ(a.selected, b.selected);
  EXPECT_EQ(a.reason, b.reason);
  ASSERT_EQ(a.candidates.size(), b.candidates.size());
  for (size_t i = 0; i < a.candidates.size(); ++i) {
    EXPECT_EQ(a.candidates[i].gain, b.candidates[i].gain);
    EXPECT_EQ(a.candidates[i].cost, b.candidates[i].cost);
    EXPECT_EQ(a.candidates[i].reason, b.candidates[i].reason);
  }

  ViewSequenceParameters other;
  other.candidates.num_azimuths = 7;
  EXPECT_FALSE(ViewSequence(other, FarthestView()).Restore(state, camera.viewpoints_, {}).ok());
}

TEST(ViewSequence, KeepsOutOfVolumes) {
  ViewSequenceParameters parameters;
  parameters.frames_per_view = 1;
  parameters.max_views = 1000;
  parameters.candidates.count = 60;
  parameters.reach.boxes = {{"wall", {0.1, -9.0, -9.0}, {9.0, 9.0, 9.0}}};
  ViewSequence sequence(parameters, FarthestView());
  Camera camera(sequence);
  camera.Set(kStart);
  int num_visited = 0;
  while (!sequence.finished()) {
    const Pose view = Candidate(sequence, sequence.next_view().selected);
    EXPECT_LT(view.translation().x(), 0.1);
    ++num_visited;
    camera.Set(view);
  }
  EXPECT_GT(num_visited, 20);
  EXPECT_NE(sequence.next_view().reason.find("keep-out"), std::string::npos);
}

TEST(ViewSequence, EndsAtOnceWhereNothingCanBeReached) {
  ViewSequenceParameters parameters;
  parameters.frames_per_view = 1;
  parameters.reach.farthest = 0.1;
  ViewSequence sequence(parameters, FarthestView());
  Camera camera(sequence);
  EXPECT_TRUE(camera.Set(LookAt(Eigen::Vector3d(0.0, -3.0, 0.1), Eigen::Vector3d::Zero())));
  EXPECT_TRUE(sequence.finished());
  EXPECT_EQ(sequence.next_view().reason,
            "none of the 36 views is left: 1 visited, 35 out of reach or in keep-out volumes");
}

// An object whose belief is looked after: two turns that only one side tells apart.
TEST(ViewSequence, GoesOnUntilTheBeliefIsSure) {
  SyntheticObject synthetic;
  synthetic.order = 2;
  synthetic.error = 0.0;
  const ConfusionModel model = MakeConfusion(synthetic.Measure(391, 100, 1));
  std::vector<OrientationHypothesis> belief = {{synthetic.Turn(0), 0.6}, {synthetic.Turn(1), 0.4}};
  ViewSequenceParameters parameters;
  parameters.frames_per_view = 1;
  parameters.candidates.count = 500;
  ViewSequence sequence(parameters, InformationGainView());
  Camera camera(sequence);
  camera.objects_.resize(1);
  PlannedObject& object = camera.objects_.front();
  object.confirmed = true;
  object.converged = true;
  object.confusion = &model;
  object.belief = belief;
  camera.Set(kStart);
  ASSERT_FALSE(sequence.finished());
  const NextView& next = sequence.next_view();
  EXPECT_GT(next.candidates[static_cast<size_t>(next.selected)].gain, 0.2);
  EXPECT_NE(next.reason.find(" nat "), std::string::npos) << next.reason;
  const Eigen::Vector3d from = Candidate(sequence, next.selected).translation().normalized();
  EXPECT_TRUE(synthetic.IsVisible(from) || synthetic.IsVisible(-from));
  belief = {{synthetic.Turn(0), 0.999}, {synthetic.Turn(1), 0.001}};
  object.belief = belief;
  for (int i = 0; i < 3 && !sequence.finished(); ++i) {
    camera.Set(Candidate(sequence, sequence.next_view().selected));
  }
  EXPECT_TRUE(sequence.finished());
  EXPECT_NE(sequence.next_view().reason.find("99.9 %"), std::string::npos)
      << sequence.next_view().reason;
}

TEST(ViewSequence, ParametersAreChecked) {
  EXPECT_TRUE(ViewSequenceParameters().Validate().ok());
  ViewSequenceParameters parameters;
  parameters.frames_per_view = 0;
  EXPECT_FALSE(parameters.Validate().ok());
  parameters = {};
  parameters.candidates.radius = 0.0;
  EXPECT_FALSE(parameters.Validate().ok());
  parameters = {};
  parameters.travel_weight = -1.0;
  EXPECT_FALSE(parameters.Validate().ok());
  parameters = {};
  parameters.stop.sure = 1.5;
  EXPECT_FALSE(parameters.Validate().ok());
}

}  // namespace
}  // namespace vantage
