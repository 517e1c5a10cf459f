#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "tools/evaluate/detection_sequence.h"
#include "tools/evaluate/simulated_sequence.h"
#include "tools/support/growing_file.h"

namespace vantage {

/// What one file of a cache holds.
struct DetectionFileContent {
  std::string model_id;
  SequenceKind kind = SequenceKind::kRandom;
  int num_views = 0;  ///< of every sequence
  std::string key;    ///< DetectionKey

  /// "MODEL-KIND-HASH.txt" with the key's hash.
  [[nodiscard]] std::string FileName() const;
};

/// A text file of the sequences of one model and kind, 0 up to some index in their order, below the
/// key that they depend on. A process that is killed while it writes leaves all but the last record
/// whole. The file is locked while it is open.
class DetectionCache {
 public:
  /// Makes folder and file if they aren't there. A last record that is not whole is cut off, see
  /// note().
  /// Errors: the system refuses, another process has the file open, it belongs to another key, or
  /// is damaged elsewhere; the message names file and line.
  static Result<DetectionCache> Open(const std::filesystem::path& folder,
                                     const DetectionFileContent& content);

  [[nodiscard]] const std::vector<DetectionSequence>& sequences() const { return sequences_; }
  /// A sentence on what was cut off; empty when nothing was.
  [[nodiscard]] const std::string& note() const { return note_; }
  /// Writes the next sequence: of index sequences().size(), with num_views views. Errors: the
  /// system refuses; the file is then as before.
  Result<void> Append(DetectionSequence sequence);

 private:
  DetectionCache(GrowingFile file, DetectionFileContent content);
  Result<void> Load();
  Result<size_t> CheckHeader(std::string_view text);
  Result<void> Take(std::string_view text, size_t position);

  GrowingFile file_;
  DetectionFileContent content_;
  std::vector<DetectionSequence> sequences_;
  std::string note_;
};

}  // namespace vantage
