#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bus/event_log.h"

namespace vantage {

/// A log that is hard to read once it is damaged: many sizes, powers of two among them; messages of
/// ours, foreign and empty ones; and data that hold the sync, single headers, and whole logs whose
/// numbers go on from that of the event that they are in.
struct MixedLog {
  std::vector<std::byte> bytes;
  std::vector<LogEvent> events;
  std::vector<size_t> offsets;  ///< of each event, and of the end
};
MixedLog MakeMixedLog(int num_events, uint64_t seed);

/// A file in memory that a reader can open under path().
class MemoryFile {
 public:
  explicit MemoryFile(const std::vector<std::byte>& bytes);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  void Put(size_t offset, std::byte value) const;
  [[nodiscard]] std::filesystem::path path() const;

 private:
  int descriptor_;
};

/// How a log reads that differs in one event from what was written.
struct ReadBack {
  std::vector<size_t> missing;  ///< events that did not come as they were written
  int num_others = 0;           ///< events that came and were not written
  LogDamage damage;
};
ReadBack ReadDamaged(const std::filesystem::path& file, const MixedLog& log);

}  // namespace vantage
