#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "common/statistics.h"
#include "tests/tools/placed_orientation.h"
#include "tools/evaluate/evaluation.h"
#include "tools/evaluate/fusion_methods.h"
#include "tools/evaluate/method_run.h"

namespace vantage {
namespace {

DetectedView Seen(const std::vector<Eigen::Quaterniond>& hypotheses, Rng& rng) {
  DetectedView view;
  view.T_world_camera = PlacedOrientation(rng.Rotation(), rng);
  for (const Eigen::Quaterniond& q : hypotheses) {
    Detection detection;
    detection.T_camera_object = view.T_world_camera.inverse() * PlacedOrientation(q, rng);
    detection.mse = rng.Uniform(0.0, 5e-6);
    view.detections.push_back(detection);
  }
  return view;
}

// Detections near the truth, some of them wrong, some views without any.
DetectionSequence MakeUp(int num_views, Rng& rng) {
  DetectionSequence sequence;
  const Eigen::Quaterniond truth = rng.Rotation();
  sequence.T_world_object = PlacedOrientation(truth, rng);
  for (int i = 0; i < num_views; ++i) {
    const Eigen::Vector3d error(rng.Normal(), rng.Normal(), rng.Normal());
    const Eigen::Quaterniond q =
        i % 5 == 3 ? rng.Rotation() : truth * ExpSo3(1.5 * kDegree * error);
    sequence.views.push_back(i % 4 == 0 ? DetectedView{} : Seen({q, rng.Rotation()}, rng));
  }
  return sequence;
}

// The last view turned by an angle about the object's z axis; refuses to say so below 0.
class LastView : public OrientationFusion {
 public:
  explicit LastView(double angle) : angle_(angle) {}
  Result<void> Add(const OrientationView& view) override {
    if (auto valid = view.Validate(); !valid) return valid;
    q_ = view.q_world_object * ExpSo3({0.0, 0.0, angle_});
    has_view_ = true;
    return {};
  }
  [[nodiscard]] Result<Eigen::Quaterniond> Estimate() const override {
    if (!has_view_ || angle_ < 0.0) return Error{ErrorCode::kNotFound, "no estimate"};
    return q_;
  }

 private:
  double angle_;
  Eigen::Quaterniond q_ = Eigen::Quaterniond::Identity();
  bool has_view_ = false;
};

// A method that is wrong by as many degrees as its function of the seed says; -1: no estimate.
FusionMethod WrongBy(const std::string& id, std::function<double(uint64_t)> error_deg) {
  FusionMethod method;
  method.info.id = id;
  method.info.label = id;
  method.make = [error_deg = std::move(error_deg)](uint64_t seed, const SymmetryGroup&) {
    return std::make_unique<LastView>(error_deg(seed) * kDegree);
  };
  return method;
}

// Estimates without looking: another orientation for each seed.
FusionMethod Guessing() {
  return WrongBy("guessing", [](uint64_t seed) { return Rng(seed).Uniform(0.0, 90.0); });
}

void ExpectSame(const std::vector<double>& a, const std::vector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_TRUE(a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i]))) << a[i] << " != " << b[i];
  }
}

TEST(RunMethod, ErrorsAreThoseAfterEveryView) {
  Rng rng(1);
  const SymmetryGroup symmetry = SymmetryGroup::Dihedral(3, {0.0, 0.0, 1.0}, {1.0, 0.0, 0.0});
  DetectionSequence sequence;
  const Eigen::Quaterniond truth = rng.Rotation();
  sequence.T_world_object = PlacedOrientation(truth, rng);
  std::vector<double> plain;
  std::vector<double> symmetric;
  for (int i = 0; i < 12; ++i) {
    if (i == 0 || i == 1 || i == 5) {  // Nothing found: the error is that before, NaN at first.
      sequence.views.emplace_back();
      plain.push_back(plain.empty() ? NAN : plain.back());
      symmetric.push_back(symmetric.empty() ? NAN : symmetric.back());
      continue;
    }
    const Eigen::Quaterniond q = rng.Rotation();
    sequence.views.push_back(Seen({q, rng.Rotation()}, rng));
    const Eigen::Quaterniond estimate = q * ExpSo3({0.0, 0.0, 7.0 * kDegree});
    double smallest = M_PI;
    for (const Eigen::Quaterniond& element : symmetry.elements) {
      smallest = std::min(smallest, GeodesicAngle(estimate * element, truth));
    }
    plain.push_back(GeodesicAngle(estimate, truth) / kDegree);
    symmetric.push_back(smallest / kDegree);
  }
  const SequenceOutcome outcome =
      RunMethod(WrongBy("last", [](uint64_t) { return 7.0; }), {&sequence, &symmetry}, 1);
  ASSERT_EQ(outcome.error_deg.size(), plain.size());
  ASSERT_EQ(outcome.symmetric_deg.size(), plain.size());
  for (size_t i = 0; i < plain.size(); ++i) {
    EXPECT_EQ(std::isnan(outcome.error_deg[i]), std::isnan(plain[i])) << i;
    EXPECT_EQ(std::isnan(outcome.symmetric_deg[i]), std::isnan(symmetric[i])) << i;
    if (std::isnan(plain[i])) continue;
    EXPECT_NEAR(outcome.error_deg[i], plain[i], 1e-6) << i;
    EXPECT_NEAR(outcome.symmetric_deg[i], symmetric[i], 1e-6) << i;
    EXPECT_LE(outcome.symmetric_deg[i], outcome.error_deg[i] + 1e-9);
  }
  EXPECT_GE(outcome.seconds_per_view, 0.0);
}

TEST(RunMethod, WithoutEstimateThereIsNoError) {
  Rng rng(2);
  const SymmetryGroup symmetry;
  const DetectionSequence sequence = MakeUp(8, rng);
  const SequenceOutcome outcome =
      RunMethod(WrongBy("silent", [](uint64_t) { return -1.0; }), {&sequence, &symmetry}, 1);
  EXPECT_EQ(outcome.symmetric_deg.size(), 8U);
  EXPECT_TRUE(std::all_of(outcome.symmetric_deg.begin(), outcome.symmetric_deg.end(), [](double e) {
    return std::isnan(e);
  }));
  const DetectionSequence empty;
  EXPECT_TRUE(RunMethod(Guessing(), {&empty, &symmetry}, 1).error_deg.empty());
  EXPECT_EQ(RunMethod(Guessing(), {&empty, &symmetry}, 1).seconds_per_view, 0.0);
}

TEST(RunMethods, TheNumberOfThreadsChangesNothing) {
  Rng rng(3);
  const So3Grid grid(8);
  std::vector<FusionMethod> methods = {Guessing()};
  for (const FusionMethod& method : FusionMethods(grid)) {
    // Those of many samples are slow, and as deterministic as their seed.
    if (method.info.id != kParticleFilterId && method.info.id != "bmm_smc") {
      methods.push_back(method);
    }
  }
  ASSERT_GT(methods.size(), 8U);
  std::vector<DetectionSequence> made_up;
  for (int i = 0; i < 7; ++i) made_up.push_back(MakeUp(3 + i, rng));
  const SymmetryGroup symmetry = SymmetryGroup::Cyclic(2, Eigen::Vector3d::UnitZ());
  std::vector<EvaluatedSequence> sequences;
  for (const DetectionSequence& each : made_up) sequences.push_back({&each, &symmetry});
  const auto run = [&](int threads, std::vector<int64_t>* progress) {
    return RunMethods(methods, sequences, {.seed = 5, .threads = threads}, {}, [&](int64_t done) {
      progress->push_back(done);
    });
  };
  std::vector<int64_t> progress;
  std::vector<int64_t> threaded_progress;
  const auto one = run(1, &progress);
  const auto three = run(3, &threaded_progress);
  EXPECT_EQ(progress, (std::vector<int64_t>{1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(threaded_progress, progress);
  ASSERT_EQ(one.size(), methods.size());
  ASSERT_EQ(three.size(), methods.size());
  for (size_t m = 0; m < methods.size(); ++m) {
    ASSERT_EQ(one[m].size(), sequences.size());
    for (size_t i = 0; i < sequences.size(); ++i) {
      ExpectSame(three[m][i].error_deg, one[m][i].error_deg);
      ExpectSame(three[m][i].symmetric_deg, one[m][i].symmetric_deg);
      // Each sequence has a seed of its own, whoever runs it.
      ExpectSame(one[m][i].error_deg, RunMethod(methods[m], sequences[i], 5 + i).error_deg);
    }
  }
}

TEST(RunMethods, StopsWhenAsked) {
  Rng rng(4);
  const SymmetryGroup symmetry;
  const DetectionSequence sequence = MakeUp(4, rng);
  const std::vector<EvaluatedSequence> sequences(50, {&sequence, &symmetry});
  const std::vector<FusionMethod> methods = {Guessing()};
  std::stop_source stop;
  const auto outcomes = RunMethods(
      methods, sequences, {.seed = 1, .threads = 2}, stop.get_token(), [&](int64_t done) {
        if (done == 3) stop.request_stop();
      });
  EXPECT_TRUE(outcomes.empty());
}

// Two models, whose sequences all see the truth itself: the methods' errors are what they add.
class MadeUpEvaluation {
 public:
  explicit MadeUpEvaluation(int num_sequences) : rng_(6) {
    models_.resize(2);
    models_[0].id = "plain";
    models_[1].id = "square";
    models_[1].symmetry = SymmetryGroup::Cyclic(4, Eigen::Vector3d::UnitZ());
    detections_.resize(2);
    for (size_t model = 0; model < 2; ++model) {
      detections_[model].model_id = models_[model].id;
      detections_[model].circles.push_back(Exact(5));
      for (int i = 0; i < num_sequences / 2; ++i) detections_[model].random.push_back(Exact(3));
    }
  }

  EvaluationResults Evaluate(const std::vector<FusionMethod>& methods) {
    EvaluationParameters parameters;
    parameters.seed = 10;
    parameters.threads = 2;
    parameters.bootstrap_resamples = 300;
    EvaluationResults results;
    EXPECT_TRUE(EvaluateMethods(models_, detections_, methods, parameters, {}, {}, &results));
    return results;
  }
  [[nodiscard]] const std::vector<ModelDetections>& detections() const { return detections_; }

 private:
  DetectionSequence Exact(int num_views) {
    DetectionSequence sequence;
    const Eigen::Quaterniond truth = rng_.Rotation();
    sequence.T_world_object = PlacedOrientation(truth, rng_);
    for (int i = 0; i < num_views; ++i) {
      sequence.views.push_back(i == 1 ? DetectedView{} : Seen({truth}, rng_));
    }
    return sequence;
  }

  Rng rng_;
  std::vector<ObjectModel> models_;
  std::vector<ModelDetections> detections_;
};

double Noise(uint64_t seed, uint64_t stream) { return Rng(seed, stream).Uniform(); }

bool Mentions(const std::vector<std::string>& sentences, const std::string& part) {
  return std::any_of(sentences.begin(), sentences.end(), [&](const std::string& sentence) {
    return sentence.find(part) != std::string::npos;
  });
}

TEST(EvaluateMethods, JudgesErrorsModuloSymmetry) {
  constexpr int kSequences = 40;
  MadeUpEvaluation evaluation(kSequences);
  const auto rough = [](uint64_t seed) {
    if (seed == 12) return -1.0;  // One sequence has no estimate,
    return seed % 5 == 0 ? 90.0 + Noise(seed, 1) : 2.0 + Noise(seed, 1);  // a fifth the wrong mode.
  };
  const auto fine = [](uint64_t seed) { return 0.5 + 0.1 * Noise(seed, 2); };
  const EvaluationResults results =
      evaluation.Evaluate({WrongBy("rough", rough), WrongBy(kBestOursId, fine)});

  // By hand: sequence i has the seed 10 + i; the second model is the same after quarter turns.
  std::vector<double> rough_deg;
  std::vector<double> fine_deg;
  double num_wrong = 0.0;
  for (uint64_t i = 0; i < kSequences; ++i) {
    double error = rough(10 + i);
    if (error < 0.0) error = 180.0;
    if (i >= kSequences / 2 && error > 90.0 && error < 92.0) error -= 90.0;
    rough_deg.push_back(error);
    fine_deg.push_back(fine(10 + i));
    num_wrong += error > results.wrong_mode_deg ? 1.0 : 0.0;
  }
  ASSERT_EQ(results.accuracy.size(), 2U);
  const MethodAccuracy& accuracy = results.accuracy[0];
  EXPECT_NEAR(accuracy.median_deg.value, Median(rough_deg), 1e-6);
  EXPECT_NEAR(accuracy.mean_deg.value, Mean(rough_deg), 1e-6);
  EXPECT_NEAR(accuracy.wrong_mode_rate.value, num_wrong / kSequences, 1e-12);
  EXPECT_GT(num_wrong, 4.0);
  EXPECT_EQ(accuracy.num_without_estimate, 1);
  EXPECT_EQ(results.accuracy[1].num_without_estimate, 0);
  EXPECT_NEAR(accuracy.difference_of_medians_deg.value, Median(rough_deg) - Median(fine_deg), 1e-6);
  EXPECT_NEAR(accuracy.difference_of_wrong_mode_rates.value, num_wrong / kSequences, 1e-12);
  for (const Interval& interval : {accuracy.median_deg,
                                   accuracy.mean_deg,
                                   accuracy.wrong_mode_rate,
                                   accuracy.median_difference_deg,
                                   accuracy.difference_of_medians_deg}) {
    EXPECT_LE(interval.low, interval.value);
    EXPECT_GE(interval.high, interval.value);
    EXPECT_LT(interval.low, interval.high);
  }
  // Of the best to itself there is no difference at all.
  const Interval& itself = results.accuracy[1].difference_of_medians_deg;
  EXPECT_EQ(itself.low, 0.0);
  EXPECT_EQ(itself.high, 0.0);
  EXPECT_TRUE(MissedBars(results).empty());
}

TEST(EvaluateMethods, KeepsTheErrorsOfEveryView) {
  MadeUpEvaluation evaluation(10);
  const EvaluationResults results =
      evaluation.Evaluate({WrongBy(kBestOursId, [](uint64_t) { return 89.0; })});
  ASSERT_EQ(results.circle.size(), 2U);
  ASSERT_EQ(results.sequences.size(), 2U);
  for (size_t model = 0; model < 2; ++model) {
    const double symmetric_deg = model == 0 ? 89.0 : 1.0;
    const CircleErrors& circle = results.circle[model];
    EXPECT_EQ(circle.model_id, evaluation.detections()[model].model_id);
    ASSERT_EQ(circle.detection_deg.size(), 5U);
    EXPECT_NEAR(circle.detection_deg[0], 0.0, 1e-5);
    EXPECT_TRUE(std::isnan(circle.detection_deg[1]));
    ASSERT_EQ(circle.step_deg.size(), 1U);
    for (size_t view = 0; view < 5; ++view) {  // Without a detection the estimate stays.
      EXPECT_NEAR(circle.step_deg[0][view], 89.0, 1e-5);
      EXPECT_NEAR(circle.step_symmetric_deg[0][view], symmetric_deg, 1e-5);
    }
    const SequenceErrors& errors = results.sequences[model];
    EXPECT_EQ(errors.num_views, 15);
    EXPECT_EQ(errors.num_found, 10);
    EXPECT_EQ(errors.detection_deg.size(), 10U);
    ASSERT_EQ(errors.final_deg.front().size(), 5U);
    for (const double error : errors.final_deg.front()) EXPECT_NEAR(error, symmetric_deg, 1e-5);
    ASSERT_EQ(errors.step_median_deg.front().size(), 3U);
    EXPECT_NEAR(errors.step_median_deg.front()[1], symmetric_deg, 1e-5);
  }
}

TEST(EvaluateMethods, ABestThatIsWorseIsReported) {
  const auto constant = [](double error_deg) {
    return [error_deg](uint64_t seed) { return error_deg + 0.01 * Noise(seed, 3); };
  };
  const auto at_times_wrong = [](uint64_t seed) { return seed % 4 == 0 ? 45.0 : 0.5; };
  MadeUpEvaluation evaluation(40);

  const auto worse = MissedBars(
      evaluation.Evaluate({WrongBy("voting", constant(1.0)), WrongBy(kBestOursId, constant(2.0))}));
  ASSERT_EQ(worse.size(), 1U);
  EXPECT_TRUE(Mentions(worse, "voting: its median"));

  // No better counts as missed too.
  const auto equal = MissedBars(
      evaluation.Evaluate({WrongBy("voting", constant(1.0)), WrongBy(kBestOursId, constant(1.0))}));
  EXPECT_TRUE(Mentions(equal, "voting: its median"));

  const auto unreliable = MissedBars(evaluation.Evaluate(
      {WrongBy("voting", constant(1.0)), WrongBy(kBestOursId, at_times_wrong)}));
  ASSERT_EQ(unreliable.size(), 2U);
  EXPECT_TRUE(Mentions(unreliable, "wrong-mode rate is 0.2500 lower"));
  EXPECT_TRUE(Mentions(unreliable, "wrong-mode rate after 3 views is 0.2500 lower"));

  const auto better = MissedBars(
      evaluation.Evaluate({WrongBy("voting", constant(3.0)), WrongBy(kBestOursId, constant(2.0))}));
  EXPECT_TRUE(better.empty());

  // Nothing to compare with is no success either.
  EXPECT_FALSE(MissedBars({}).empty());
  EXPECT_FALSE(MissedBars(evaluation.Evaluate({WrongBy("voting", constant(3.0))})).empty());
}

TEST(EvaluateMethods, OthersOfOursAreNoBar) {
  MadeUpEvaluation evaluation(20);
  FusionMethod other = WrongBy("other", [](uint64_t) { return 0.1; });
  other.info.is_past_paper = true;
  const auto missed =
      MissedBars(evaluation.Evaluate({other, WrongBy(kBestOursId, [](uint64_t) { return 2.0; })}));
  EXPECT_TRUE(missed.empty());
}

TEST(EvaluateMethods, ParametersAreChecked) {
  const auto ok = [](const std::function<void(EvaluationParameters*)>& change) {
    EvaluationParameters parameters;
    change(&parameters);
    return parameters.Validate().ok();
  };
  EXPECT_TRUE(ok([](EvaluationParameters*) {}));
  EXPECT_FALSE(ok([](EvaluationParameters* p) { p->threads = 0; }));
  EXPECT_FALSE(ok([](EvaluationParameters* p) { p->wrong_mode_deg = NAN; }));
  EXPECT_FALSE(ok([](EvaluationParameters* p) { p->particle_runs = -1; }));
  EXPECT_FALSE(ok([](EvaluationParameters* p) { p->bootstrap_resamples = 0; }));
}

}  // namespace
}  // namespace vantage
