#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "common/so3.h"

namespace vantage {

/// What was detected in one simulated view; no orientation: looked, not found.
struct SeenOrientation {
  std::optional<Eigen::Quaterniond> q_world_object;
  double mse = 0.0;  ///< m^2, of the detection (paper eq. 4)
};

/// Which view it was: the key that the cache was opened with says all the rest.
struct SeenFrom {
  int sequence = 0;
  int step = 0;  ///< of the sequence, which decides the noise
  Pose T_world_camera = Pose::Identity();
};

/// Detections of simulated views of one object, kept in a text file of one line a view below the
/// key that they depend on. Lines are appended whole: an interrupted or killed run leaves all but
/// perhaps the last; what does not agree with its checksum is made again. For any number of
/// threads; views may be kept in any order.
class ConfusionViewCache {
 public:
  /// @param name begins the file's name. @param key lines of text.
  /// Errors: the system refuses folder or file; the file is of another key.
  static Result<std::unique_ptr<ConfusionViewCache>> Open(const std::filesystem::path& folder,
                                                          const std::string& name,
                                                          const std::string& key);
  ~ConfusionViewCache();
  ConfusionViewCache(const ConfusionViewCache&) = delete;
  ConfusionViewCache& operator=(const ConfusionViewCache&) = delete;

  std::optional<SeenOrientation> Find(const SeenFrom& from);
  /// Error: the system refuses to write.
  Result<void> Keep(const SeenFrom& from, const SeenOrientation& seen);

  /// A sentence on damage; empty when there was none.
  [[nodiscard]] const std::string& note() const { return note_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

 private:
  explicit ConfusionViewCache(std::filesystem::path file) : file_(std::move(file)) {}
  Result<void> Load(const std::string& head);
  void TakeLines(std::string_view lines);
  Result<void> Append(std::string_view text) const;

  std::filesystem::path file_;
  int descriptor_ = -1;
  std::string note_;
  std::mutex mutex_;
  std::map<uint64_t, SeenOrientation> seen_;  // By the hash of SeenFrom.
};

}  // namespace vantage
