#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/evaluate/evaluation_results.h"
#include "tools/evaluate/method_run.h"

namespace vantage {

/// FNV-1a of the running executable's bytes. Error: the system refuses to read it.
Result<uint64_t> HashOfThisProgram();

/// Outcomes of methods, kept in a folder: a text file for each program and method with its
/// parameters, a line for each sequence and seed. What does not agree with its checksum is not
/// there. Lines are appended whole, so that a run that is interrupted, or killed, leaves all but
/// perhaps the last. For any number of threads.
class MethodCache {
 public:
  /// Makes the folder if it isn't there; a file is read when its method is first asked for.
  /// @param program_hash outcomes of another program are not used.
  /// Error: the system refuses to make the folder.
  static Result<std::unique_ptr<MethodCache>> Create(const std::filesystem::path& folder,
                                                     uint64_t program_hash);
  ~MethodCache();
  MethodCache(const MethodCache&) = delete;
  MethodCache& operator=(const MethodCache&) = delete;

  /// The outcome kept for these detections, truth, symmetry and seed.
  std::optional<SequenceOutcome> Find(const MethodInfo& method,
                                      const EvaluatedSequence& evaluated,
                                      uint64_t seed);
  /// Where the system refuses, that is noted and nothing is kept.
  void Keep(const MethodInfo& method,
            const EvaluatedSequence& evaluated,
            uint64_t seed,
            const SequenceOutcome& outcome);

  /// Sentences on damaged files and on those that can't be written.
  [[nodiscard]] std::vector<std::string> Notes();
  /// Outcomes that Find() had.
  [[nodiscard]] int64_t num_found();

 private:
  MethodCache(std::filesystem::path folder, uint64_t program_hash);
  struct File {
    std::filesystem::path path;
    int descriptor = -1;                           // Below 0: can't be written.
    bool is_sound = false;                         // There, and nothing in it is damaged.
    std::map<uint64_t, SequenceOutcome> outcomes;  // By the hash of sequence and seed.
  };
  File& FileOf(const MethodInfo& method);
  void Read(File* file);
  void Open(const std::string& head, File* file);
  void Abandon(File* file);

  std::filesystem::path folder_;
  uint64_t program_hash_;
  std::mutex mutex_;
  std::map<std::string, File> files_;  // By id and parameters.
  std::vector<std::string> notes_;
  int64_t num_found_ = 0;
};

}  // namespace vantage
