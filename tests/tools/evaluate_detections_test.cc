#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <sstream>

#include "common/format.h"
#include "tests/perception/model_test_support.h"
#include "tools/evaluate/detection_cache.h"
#include "tools/evaluate/detection_key.h"
#include "tools/evaluate/detection_run.h"
#include "tools/evaluate/detection_text.h"
#include "tools/support/hash.h"

namespace vantage {
namespace {

constexpr int kNumViews = 2;

Pose RandomPose(Rng& rng) {
  Pose pose = Pose::Identity();
  pose.linear() = rng.Rotation().toRotationMatrix();
  for (double& value : pose.translation()) value = rng.Normal();
  return pose;
}

// Of any numbers that can be; every third view without detections.
DetectionSequence RandomSequence(int index, Rng& rng) {
  DetectionSequence sequence{"thing", index, RandomPose(rng), {}};
  for (int view = 0; view < kNumViews; ++view) {
    DetectedView detected{RandomPose(rng), {}};
    const int count = (index + view) % 3;
    for (int i = 0; i < count; ++i) {
      detected.detections.push_back({.model_id = "thing",
                                     .cluster = 7,
                                     .T_camera_object = RandomPose(rng),
                                     .mse = 1e-7 * rng.Uniform(),
                                     .inlier_fraction = rng.Uniform(),
                                     .verification_score = rng.Uniform()});
    }
    sequence.views.push_back(detected);
  }
  return sequence;
}

std::vector<DetectionSequence> RandomSequences(int count) {
  Rng rng(5);
  std::vector<DetectionSequence> sequences;
  for (int i = 0; i < count; ++i) sequences.push_back(RandomSequence(i, rng));
  return sequences;
}

// Not of the text: a comparison that errors in writing can't touch.
void ExpectSame(const DetectionSequence& a, const DetectionSequence& b) {
  EXPECT_EQ(a.model_id, b.model_id);
  EXPECT_EQ(a.index, b.index);
  EXPECT_EQ(a.T_world_object.matrix(), b.T_world_object.matrix());
  ASSERT_EQ(a.views.size(), b.views.size());
  for (size_t i = 0; i < a.views.size(); ++i) {
    EXPECT_EQ(a.views[i].T_world_camera.matrix(), b.views[i].T_world_camera.matrix());
    ASSERT_EQ(a.views[i].detections.size(), b.views[i].detections.size());
    for (size_t j = 0; j < a.views[i].detections.size(); ++j) {
      const Detection& x = a.views[i].detections[j];
      const Detection& y = b.views[i].detections[j];
      EXPECT_EQ(x.model_id, y.model_id);
      EXPECT_EQ(x.cluster, y.cluster);
      EXPECT_EQ(x.T_camera_object.matrix(), y.T_camera_object.matrix());
      EXPECT_EQ(x.mse, y.mse);
      EXPECT_EQ(x.inlier_fraction, y.inlier_fraction);
      EXPECT_EQ(x.verification_score, y.verification_score);
    }
  }
}

void ExpectFirstOf(const std::vector<DetectionSequence>& all,
                   const std::vector<DetectionSequence>& some) {
  ASSERT_LE(some.size(), all.size());
  for (size_t i = 0; i < some.size(); ++i) ExpectSame(all[i], some[i]);
}

std::string ReadText(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

// A new file: to empty the old one makes some file systems wait for the disk.
void WriteText(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::remove(file);
  std::ofstream(file, std::ios::binary) << text;
}

// A folder with the file of some content and, in it, some sequences.
class DetectionCacheTest : public testing::Test {
 protected:
  DetectionCacheTest() { Fill(); }

  void Fill() {
    Result<DetectionCache> cache = Open();
    ASSERT_TRUE(cache.ok());
    for (size_t i = cache->sequences().size(); i < sequences_.size(); ++i) {
      ASSERT_TRUE(cache->Append(sequences_[i]).ok());
    }
  }
  [[nodiscard]] Result<DetectionCache> Open() const {
    return DetectionCache::Open(folder_.path(), content_);
  }
  [[nodiscard]] std::filesystem::path file() const { return folder_.path() / content_.FileName(); }
  // The file's text with the last record changed and its checksum made right again.
  [[nodiscard]] std::string WithLastRecord(const std::function<void(std::string*)>& change) const {
    const std::string text = ReadText(file());
    const size_t begin = text.rfind("\nsequence ") + 1;
    std::string record = text.substr(begin, text.rfind("\nend ") + 1 - begin);
    change(&record);
    record += Format("end %016jx\n", static_cast<uintmax_t>(Fnv1a(record)));
    return text.substr(0, begin) + record;
  }

  const ScratchFolder folder_;
  const DetectionFileContent content_{
      "thing", SequenceKind::kRandom, kNumViews, "seed 1\ncamera 640 480\n"};
  const std::vector<DetectionSequence> sequences_ = RandomSequences(4);
};

TEST_F(DetectionCacheTest, GivesBackEveryNumberExactly) {
  const Result<DetectionCache> cache = Open();
  ASSERT_TRUE(cache.ok());
  EXPECT_EQ(cache->note(), "");
  ASSERT_EQ(cache->sequences().size(), sequences_.size());
  ExpectFirstOf(sequences_, cache->sequences());
}

TEST_F(DetectionCacheTest, GoesOnAfterAnEndAtAnyByte) {
  const std::string whole = ReadText(file());
  size_t fewest = sequences_.size();
  for (size_t size = 0; size < whole.size(); ++size) {
    WriteText(file(), whole.substr(0, size));
    {
      const Result<DetectionCache> cache = Open();
      ASSERT_TRUE(cache.ok()) << size << ": " << cache.error().message;
      ASSERT_LT(cache->sequences().size(), sequences_.size());
      ExpectFirstOf(sequences_, cache->sequences());
      fewest = std::min(fewest, cache->sequences().size());
      const bool is_cut_between = size == 0 || whole.compare(size - 1, 1, "\n") == 0;
      EXPECT_TRUE(is_cut_between || !cache->note().empty()) << size;
    }
    Fill();
    ASSERT_EQ(ReadText(file()), whole) << size;
  }
  EXPECT_EQ(fewest, 0U);
}

TEST_F(DetectionCacheTest, NeverTakesADamagedByteForData) {
  const std::string whole = ReadText(file());
  const size_t last = whole.rfind("\nsequence ") + 1;
  for (size_t i = 0; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 1);
    WriteText(file(), damaged);
    const Result<DetectionCache> cache = Open();
    if (i + 1 >= last) {
      // Without the line's end before it, the last record is one with the record before.
      ASSERT_TRUE(cache.ok()) << i;
      EXPECT_EQ(cache->sequences().size(), sequences_.size() - (i >= last ? 1 : 2));
      ExpectFirstOf(sequences_, cache->sequences());
      EXPECT_NE(cache->note().find("line"), std::string::npos);
    } else {
      ASSERT_FALSE(cache.ok()) << i;
      EXPECT_NE(cache.error().message.find(file().string() + ", line "), std::string::npos);
    }
  }
}

TEST_F(DetectionCacheTest, NamesTheLineOfDamage) {
  const std::string whole = ReadText(file());
  const size_t second = whole.find("\nsequence 1 ") + 1;
  const auto line =
      1 + std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(second), '\n');
  std::string damaged = whole;
  damaged[second + 30] = 'x';
  WriteText(file(), damaged);
  const Result<DetectionCache> cache = Open();
  ASSERT_FALSE(cache.ok());
  EXPECT_EQ(cache.error().code, ErrorCode::kCorrupt);
  EXPECT_NE(cache.error().message.find(Format("line %td:", line)), std::string::npos);
  EXPECT_EQ(ReadText(file()), damaged);
}

TEST_F(DetectionCacheTest, RefusesAWrongRecordWithARightChecksum) {
  const std::string whole = ReadText(file());
  const auto replace = [](const std::string& from, const std::string& to) {
    return [from, to](std::string* record) {
      const size_t at = record->find(from);
      ASSERT_NE(at, std::string::npos);
      record->replace(at, from.size(), to);
    };
  };
  // Of the first pose, the number after three others.
  const auto break_pose = [](const char* number) {
    return [number](std::string* record) {
      size_t begin = 0;
      for (int word = 0; word < 3; ++word) begin = record->find(' ', begin) + 1;
      record->replace(begin, record->find(' ', begin) - begin, number);
    };
  };
  EXPECT_EQ(WithLastRecord([](std::string*) {}), whole);
  const std::vector<std::function<void(std::string*)>> changes = {
      replace("sequence 3", "sequence 2"),
      replace("sequence 3", "sequence 4"),
      replace("sequence 3", "sequence -3"),
      replace("sequence 3 2", "sequence 3 1"),
      replace("sequence 3 2", "sequence 3 2 1"),
      replace("\nview", "\nnear"),
      replace("\nview", "\nfound"),
      break_pose("nan"),
      break_pose("inf"),
      break_pose("1.5"),
      break_pose("0.1"),
      break_pose(""),
      [](std::string* record) { *record += "found 0\n"; },
      [](std::string* record) { *record += "view 1 0 0 0 0 1 0 0 0 0 1 0\n"; },
      [](std::string* record) { *record += "\n"; },
      [](std::string* record) { *record += "found 0 1 0 0 0 0 1 0 0 0 0 1 0 -1 0.5 0.5\n"; },
      [](std::string* record) { *record += "found 0 1 0 0 0 0 1 0 0 0 0 1 0 0 1.5 0.5\n"; },
      [](std::string* record) { *record += "found 0 -1 0 0 0 0 1 0 0 0 0 1 0 0 0.5 0.5\n"; },
  };
  for (size_t i = 0; i < changes.size(); ++i) {
    WriteText(file(), whole);
    WriteText(file(), WithLastRecord(changes[i]));
    const Result<DetectionCache> cache = Open();
    ASSERT_FALSE(cache.ok()) << i;
    EXPECT_EQ(cache.error().code, ErrorCode::kCorrupt);
    EXPECT_NE(cache.error().message.find(", line "), std::string::npos) << cache.error().message;
  }
}

TEST_F(DetectionCacheTest, OfAnotherKeyIsAnotherFile) {
  DetectionFileContent other = content_;
  other.key = "seed 2\ncamera 640 480\n";
  {
    const Result<DetectionCache> cache = DetectionCache::Open(folder_.path(), other);
    ASSERT_TRUE(cache.ok());
    EXPECT_TRUE(cache->sequences().empty());
  }
  EXPECT_EQ(folder_.CountEntries(), 2);
  // A file under the other's name is not taken for it.
  std::filesystem::copy_file(
      file(), folder_.path() / other.FileName(), std::filesystem::copy_options::overwrite_existing);
  const Result<DetectionCache> mistaken = DetectionCache::Open(folder_.path(), other);
  ASSERT_FALSE(mistaken.ok());
  EXPECT_NE(mistaken.error().message.find("line 2: \"seed 1\", expected \"seed 2\""),
            std::string::npos)
      << mistaken.error().message;
}

TEST_F(DetectionCacheTest, IsLockedWhileItIsOpen) {
  {
    const Result<DetectionCache> first = Open();
    ASSERT_TRUE(first.ok());
    const Result<DetectionCache> second = Open();
    ASSERT_FALSE(second.ok());
    EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
  }
  EXPECT_TRUE(Open().ok());
}

TEST_F(DetectionCacheTest, RefusesWhatIsNoFolder) {
  EXPECT_FALSE(DetectionCache::Open(file(), content_).ok());
}

ObjectModel Bracket() {
  Result<ObjectModel> model =
      LoadObjectModel(std::filesystem::path(VANTAGE_SOURCE_DIR) / "models/bracket");
  EXPECT_TRUE(model.ok());
  return std::move(model).value();
}

TEST(DetectionKey, ChangesWithAllThatDetectionsDependOn) {
  const ObjectModel bracket = Bracket();
  std::set<std::string> keys = {DetectionKey(bracket, SequenceKind::kRandom, {}),
                                DetectionKey(bracket, SequenceKind::kCircle, {})};
  EXPECT_EQ(keys.size(), 2U);
  const std::vector<std::function<void(SimulationParameters*)>> changes = {
      [](auto* p) { p->seed = 2; },
      [](auto* p) { p->views.random_views = 11; },
      [](auto* p) { p->views.aim_jitter = 0.02; },
      [](auto* p) { p->camera.fx = std::nextafter(p->camera.fx, 1e3); },
      [](auto* p) { p->sensor.bias = false; },
      [](auto* p) { p->sensor.axial_sigma = 0.05; },
      [](auto* p) { p->estimator.estimation.hypotheses_per_cluster = 1; },
      [](auto* p) { p->estimator.table.angle_step_deg = 10.0; },
      [](auto* p) { p->estimator.estimation.segmentation.plane.min_share = 0.1; },
      [](auto* p) { p->estimator.estimation.segmentation.noise.lateral_px = 0.7; },
      [](auto* p) { p->estimator.estimation.normals.radius = 0.006; },
      [](auto* p) { p->estimator.voting.spread = 0.2; },
      [](auto* p) { p->estimator.estimation.verification.min_score = 0.7; },
      [](auto* p) { p->estimator.estimation.refinement.noise.axial_base = 0.001; },
  };
  for (const auto& change : changes) {
    SimulationParameters parameters;
    change(&parameters);
    EXPECT_TRUE(keys.insert(DetectionKey(bracket, SequenceKind::kRandom, parameters)).second)
        << keys.size();
  }
  const std::vector<std::function<void(ObjectModel*)>> other_models = {
      [](auto* m) { m->id = "clamp"; },
      [](auto* m) { m->mesh_hash ^= 1U; },
      [](auto* m) { m->samples[3].normal.x() += 1e-6F; },
      [](auto* m) { m->center.z() = 0.0; },
      [](auto* m) { m->symmetry = SymmetryGroup::Cyclic(2, Eigen::Vector3d::UnitZ()); },
      [](auto* m) { m->symmetry = SymmetryGroup::Continuous(Eigen::Vector3d::UnitZ(), false); },
  };
  for (const auto& change : other_models) {
    ObjectModel model = bracket;
    change(&model);
    EXPECT_TRUE(keys.insert(DetectionKey(model, SequenceKind::kRandom, {})).second) << keys.size();
  }
  // What has no part in a circle does not make it again.
  SimulationParameters parameters;
  parameters.views.random_views = 11;
  EXPECT_FALSE(keys.insert(DetectionKey(bracket, SequenceKind::kCircle, parameters)).second);
}

// Two views a sequence.
DetectionRequest SmallRequest(const std::filesystem::path& cache, int random, int threads) {
  DetectionRequest request;
  request.simulation.views.random_views = 2;
  request.simulation.views.circle_views = 3;
  request.random_sequences = random;
  request.threads = threads;
  request.cache = cache;
  return request;
}

DetectionRun RunBracket(const DetectionRequest& request, const std::stop_token& stop = {}) {
  const std::vector<ObjectModel> models = {Bracket()};
  Result<DetectionRun> run = RunDetections(models, request, stop, {});
  EXPECT_TRUE(run.ok());
  return std::move(run).value();
}

// Text of every file in a folder, by name.
std::map<std::string, std::string> Contents(const ScratchFolder& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    contents[entry.path().filename()] = ReadText(entry.path());
  }
  return contents;
}

TEST(RunDetections, FindsTheObjectWhereItIs) {
  const ScratchFolder folder;
  const DetectionRun run = RunBracket(SmallRequest(folder.path(), 1, 1));
  EXPECT_TRUE(run.is_complete);
  EXPECT_EQ(run.views_made, 5);
  EXPECT_EQ(run.views_reused, 0);
  ASSERT_EQ(run.models.size(), 1U);
  ASSERT_EQ(run.models[0].circles.size(), 1U);
  ASSERT_EQ(run.models[0].random.size(), 1U);
  const ObjectModel bracket = Bracket();
  for (const DetectionSequence& sequence : {run.models[0].circles[0], run.models[0].random[0]}) {
    EXPECT_EQ(sequence.model_id, "bracket");
    for (const DetectedView& view : sequence.views) {
      ASSERT_FALSE(view.detections.empty());
      ASSERT_LE(view.detections.size(), 3U);
      const Pose T = view.T_world_camera * view.detections[0].T_camera_object;
      EXPECT_LT(GeodesicAngle(Eigen::Quaterniond(T.linear()),
                              Eigen::Quaterniond(sequence.T_world_object.linear())),
                5.0 * kDegree);
      EXPECT_LT((T * bracket.center - sequence.T_world_object * bracket.center).norm(), 0.005);
      for (const Detection& detection : view.detections) {
        EXPECT_EQ(detection.model_id, "bracket");
        EXPECT_EQ(detection.cluster, view.detections[0].cluster);
      }
    }
  }
}

TEST(RunDetections, IsTheSameForAnyNumberOfThreadsAndWhenMoreIsAskedForLater) {
  const ScratchFolder at_once;
  const DetectionRun whole = RunBracket(SmallRequest(at_once.path(), 4, 1));
  const ScratchFolder in_parts;
  RunBracket(SmallRequest(in_parts.path(), 1, 2));
  const DetectionRun rest = RunBracket(SmallRequest(in_parts.path(), 4, 2));
  EXPECT_EQ(rest.views_reused, 5);
  EXPECT_EQ(rest.views_made, 6);
  EXPECT_EQ(Contents(at_once), Contents(in_parts));
  EXPECT_EQ(Contents(at_once).size(), 2U);
  ASSERT_EQ(rest.models[0].random.size(), 4U);
  ExpectFirstOf(whole.models[0].random, rest.models[0].random);
  ExpectFirstOf(whole.models[0].circles, rest.models[0].circles);
  const DetectionRun fewer = RunBracket(SmallRequest(in_parts.path(), 2, 2));
  EXPECT_EQ(fewer.models[0].random.size(), 2U);
  EXPECT_EQ(fewer.views_reused, 7);
  EXPECT_EQ(fewer.views_made, 0);
}

TEST(RunDetections, KeepsWhatIsDoneWhenStopped) {
  const ScratchFolder folder;
  const DetectionRequest request = SmallRequest(folder.path(), 6, 2);
  const std::vector<ObjectModel> models = {Bracket()};
  std::stop_source stop;
  std::vector<int64_t> done;
  const Result<DetectionRun> run =
      RunDetections(models, request, stop.get_token(), [&](const DetectionProgress& progress) {
        EXPECT_EQ(progress.views_total, 15);
        done.push_back(progress.views_done);
        if (progress.views_done > 0) stop.request_stop();
      });
  ASSERT_TRUE(run.ok());
  EXPECT_FALSE(run->is_complete);
  EXPECT_TRUE(std::is_sorted(done.begin(), done.end()));
  EXPECT_EQ(done.front(), 0);
  EXPECT_EQ(done.back(), run->views_made);
  EXPECT_GE(run->views_made, 2);
  EXPECT_LE(run->views_made, 7);  // The first that is done, and one more of the other thread.
  const DetectionRun rest = RunBracket(request);
  EXPECT_TRUE(rest.is_complete);
  EXPECT_EQ(rest.views_made, 15 - run->views_made);
}

TEST(RunDetections, RefusesWhatCantBe) {
  const ScratchFolder folder;
  const std::vector<ObjectModel> one = {Bracket()};
  const std::vector<ObjectModel> twice = {one[0], one[0]};
  EXPECT_FALSE(RunDetections(twice, SmallRequest(folder.path(), 1, 1), {}, {}).ok());
  EXPECT_FALSE(RunDetections(one, SmallRequest(folder.path(), -1, 1), {}, {}).ok());
  EXPECT_FALSE(RunDetections(one, SmallRequest(folder.path(), 1, 0), {}, {}).ok());
  DetectionRequest request = SmallRequest(folder.path(), 1, 1);
  request.simulation.views.nearest_distance = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(RunDetections(one, request, {}, {}).ok());
  std::vector<ObjectModel> bare = one;
  bare[0].samples.clear();
  EXPECT_FALSE(RunDetections(bare, SmallRequest(folder.path(), 1, 2), {}, {}).ok());
  EXPECT_TRUE(RunDetections({}, SmallRequest(folder.path(), 1, 1), {}, {})->is_complete);
}

}  // namespace
}  // namespace vantage
