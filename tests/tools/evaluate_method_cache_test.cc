// Outcomes of methods that are kept: found again as they were, never taken for others, and made
// again where the file is damaged.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "common/rng.h"
#include "perception/model/file_bytes.h"
#include "tests/tools/run_program.h"
#include "tools/evaluate/method_cache.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

void ExpectSame(const std::vector<double>& a, const std::vector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_TRUE(a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i]))) << a[i] << " " << b[i];
  }
}

class MethodCacheTest : public ScratchTest {
 protected:
  static constexpr int kViews = 3;

  void SetUp() override {
    ScratchTest::SetUp();
    Rng rng(5);
    for (int i = 0; i < 4; ++i) {
      DetectionSequence sequence;
      sequence.index = i;
      sequence.T_world_object.linear() = rng.Rotation().toRotationMatrix();
      sequence.views.resize(kViews);
      for (DetectedView& view : sequence.views) {
        view.detections.resize(1);
        view.detections[0].T_camera_object.linear() = rng.Rotation().toRotationMatrix();
        view.detections[0].mse = rng.Uniform(0.0, 1e-5);
      }
      sequences_.push_back(sequence);
      SequenceOutcome outcome;
      outcome.seconds_per_view = rng.Uniform();
      outcome.error_deg = {kNone, rng.Uniform(), 4.9406564584124654e-324};
      outcome.symmetric_deg = {kNone, rng.Uniform(), 1.0 / 3.0};
      outcomes_.push_back(outcome);
    }
  }
  [[nodiscard]] fs::path folder() const { return scratch() / "cache" / "methods"; }
  [[nodiscard]] std::unique_ptr<MethodCache> Open(uint64_t program = 1) const {
    auto cache = MethodCache::Create(folder(), program);
    EXPECT_TRUE(cache.ok());
    return std::move(cache).value();
  }
  [[nodiscard]] EvaluatedSequence Sequence(size_t i) const { return {&sequences_[i], &symmetry_}; }
  void KeepAll() const {
    const auto cache = Open();
    for (size_t i = 0; i < sequences_.size(); ++i) {
      cache->Keep(method_, Sequence(i), i, outcomes_[i]);
    }
    EXPECT_TRUE(cache->Notes().empty());
  }
  void ExpectKept(MethodCache* cache, size_t i) const {
    const auto found = cache->Find(method_, Sequence(i), i);
    ASSERT_TRUE(found.has_value()) << i;
    ExpectSame(found->error_deg, outcomes_[i].error_deg);
    ExpectSame(found->symmetric_deg, outcomes_[i].symmetric_deg);
    EXPECT_EQ(found->seconds_per_view, outcomes_[i].seconds_per_view);
  }
  [[nodiscard]] fs::path OnlyFile() const {
    const std::vector<std::string> files = ListTree(folder());
    EXPECT_EQ(files.size(), 1U);
    return files.empty() ? "" : files.front();
  }
  [[nodiscard]] std::string Text() const {
    const Result<std::string> text = ReadFileBytes(OnlyFile(), size_t{1} << 20U);
    EXPECT_TRUE(text.ok());
    return text.ok() ? *text : "";
  }
  void Overwrite(const std::string& text) const {
    std::ofstream(OnlyFile(), std::ios::binary | std::ios::trunc) << text;
  }

  MethodInfo method_{"slow", "Slow", "sigma 4 deg", false, false};
  SymmetryGroup symmetry_ = SymmetryGroup::Cyclic(2, Eigen::Vector3d::UnitZ());
  std::vector<DetectionSequence> sequences_;
  std::vector<SequenceOutcome> outcomes_;
};

TEST_F(MethodCacheTest, FindsBitForBitWhatWasKept) {
  KeepAll();
  const auto cache = Open();
  for (size_t i = 0; i < sequences_.size(); ++i) ExpectKept(cache.get(), i);
  EXPECT_EQ(cache->num_found(), 4);
  EXPECT_TRUE(cache->Notes().empty());
}

TEST_F(MethodCacheTest, WhatDiffersInAnythingIsNotFound) {
  KeepAll();
  const auto cache = Open();
  MethodInfo other = method_;
  other.parameters = "sigma 2 deg";
  EXPECT_FALSE(cache->Find(other, Sequence(0), 0).has_value());
  other = method_;
  other.id = "other";
  EXPECT_FALSE(cache->Find(other, Sequence(0), 0).has_value());
  EXPECT_FALSE(cache->Find(method_, Sequence(0), 1).has_value());
  EXPECT_FALSE(cache->Find(method_, Sequence(1), 0).has_value());
  EXPECT_FALSE(Open(2)->Find(method_, Sequence(0), 0).has_value());

  for (const SymmetryGroup& symmetry :
       {SymmetryGroup::None(),
        SymmetryGroup::Cyclic(2, Eigen::Vector3d::UnitX()),
        SymmetryGroup::Continuous(Eigen::Vector3d::UnitZ(), false),
        SymmetryGroup::Continuous(Eigen::Vector3d::UnitZ(), true)}) {
    EXPECT_FALSE(cache->Find(method_, {&sequences_[0], &symmetry}, 0).has_value());
  }
  DetectionSequence changed = sequences_[0];
  changed.views[1].detections[0].mse = std::nextafter(changed.views[1].detections[0].mse, 1.0);
  EXPECT_FALSE(cache->Find(method_, {&changed, &symmetry_}, 0).has_value());
  changed = sequences_[0];
  changed.T_world_object.translation().x() = 1.0;
  EXPECT_FALSE(cache->Find(method_, {&changed, &symmetry_}, 0).has_value());
  changed = sequences_[0];
  changed.views.pop_back();
  EXPECT_FALSE(cache->Find(method_, {&changed, &symmetry_}, 0).has_value());
  ExpectKept(cache.get(), 0);
}

TEST_F(MethodCacheTest, AFileCutAnywhereKeepsTheLinesBefore) {
  KeepAll();
  const std::string whole = Text();
  for (size_t size = 0; size < whole.size(); ++size) {
    Overwrite(whole.substr(0, size));
    const auto cache = Open();
    size_t num_found = 0;
    for (size_t i = 0; i < sequences_.size(); ++i) {
      if (!cache->Find(method_, Sequence(i), i)) {
        cache->Keep(method_, Sequence(i), i, outcomes_[i]);
      } else {
        ++num_found;
      }
    }
    // A line is whole with or without its end; the first is the head.
    size_t num_whole = 0;
    for (size_t at = whole.find('\n'); at != std::string::npos; at = whole.find('\n', at + 1)) {
      if (at <= size) ++num_whole;
    }
    EXPECT_EQ(num_found, num_whole == 0 ? 0 : num_whole - 1) << size;
    // What was mended is sound.
    const auto mended = Open();
    for (size_t i = 0; i < sequences_.size(); ++i) ExpectKept(mended.get(), i);
    EXPECT_TRUE(mended->Notes().empty()) << size;
  }
}

TEST_F(MethodCacheTest, AFlippedByteLosesItsLineAloneAndIsNoted) {
  KeepAll();
  const std::string whole = Text();
  for (size_t at = whole.find('\n') + 1; at < whole.size(); at += 7) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    Overwrite(damaged);
    const auto cache = Open();
    size_t num_missing = 0;
    for (size_t i = 0; i < sequences_.size(); ++i) {
      const auto found = cache->Find(method_, Sequence(i), i);
      if (!found) {
        ++num_missing;
      } else {
        ExpectSame(found->symmetric_deg, outcomes_[i].symmetric_deg);
      }
    }
    // A flipped end of a line takes the next one with it.
    EXPECT_EQ(num_missing, whole[at] == '\n' && at + 1 < whole.size() ? 2U : 1U) << at;
    ASSERT_EQ(cache->Notes().size(), 1U) << at;
    EXPECT_NE(cache->Notes()[0].find(OnlyFile().string()), std::string::npos);
  }
}

TEST_F(MethodCacheTest, AFileThatCannotBeWrittenIsNotedOnceAndWorkGoesOn) {
  KeepAll();
  const fs::path file = OnlyFile();
  fs::remove(file);
  fs::create_directory(file);
  const auto cache = Open();
  for (size_t i = 0; i < sequences_.size(); ++i) {
    EXPECT_FALSE(cache->Find(method_, Sequence(i), i).has_value());
    cache->Keep(method_, Sequence(i), i, outcomes_[i]);
  }
  ASSERT_FALSE(cache->Notes().empty());
  EXPECT_LE(cache->Notes().size(), 2U);
}

TEST_F(MethodCacheTest, AFolderThatCannotBeMadeIsAnError) {
  std::ofstream(scratch() / "cache") << "a file";
  const auto cache = MethodCache::Create(folder(), 1);
  ASSERT_FALSE(cache.ok());
  EXPECT_NE(cache.error().message.find(folder().string()), std::string::npos);
}

TEST_F(MethodCacheTest, SlowMethodsAreRunOnceOthersAlways) {
  int num_made = 0;
  class Nothing final : public OrientationFusion {
   public:
    Result<void> Add(const OrientationView&) override { return {}; }
    [[nodiscard]] Result<Eigen::Quaterniond> Estimate() const override {
      return Eigen::Quaterniond::Identity();
    }
  };
  const FusionMaker make = [&](uint64_t, const SymmetryGroup&) {
    ++num_made;
    return std::make_unique<Nothing>();
  };
  const std::vector<FusionMethod> methods = {{method_, true, make},
                                             {{"fast", "Fast", "", false, false}, false, make}};
  std::vector<EvaluatedSequence> all;
  for (size_t i = 0; i < sequences_.size(); ++i) all.push_back(Sequence(i));
  std::vector<std::vector<double>> finals;
  for (int run = 0; run < 2; ++run) {
    const auto cache = Open();
    const auto outcomes = RunMethods(methods, all, {9, 1, cache.get()}, {}, {});
    ASSERT_EQ(outcomes.size(), 2U);
    finals.emplace_back();
    for (const SequenceOutcome& outcome : outcomes[0]) {
      finals.back().push_back(outcome.symmetric_deg.back());
    }
    EXPECT_EQ(cache->num_found(), run == 0 ? 0 : 4);
  }
  EXPECT_EQ(num_made, 8 + 4);
  EXPECT_EQ(finals[0], finals[1]);
}

TEST(ThisProgram, HasAHash) {
  const Result<uint64_t> hash = HashOfThisProgram();
  ASSERT_TRUE(hash.ok()) << hash.error().message;
  EXPECT_EQ(*hash, *HashOfThisProgram());
}

}  // namespace
}  // namespace vantage
