#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace vantage {

/// What was wrong with a log where it was read.
struct LogDamage {
  /// A stretch that was skipped, or an event whose header was mended.
  struct Place {
    int64_t offset = 0;        ///< bytes from the start of the file
    int64_t bytes = 0;         ///< skipped; 0: the event was mended and kept
    int64_t first_number = 0;  ///< of the event mended, or the events lost, by the numbers around
    int64_t num_events = 0;    ///< from first_number on; 0: none is missing
    std::string reason;        ///< in words

    /// One line for people: where, which event, what.
    [[nodiscard]] std::string Describe() const;
  };
  static constexpr size_t kMaxPlaces = 1000;  ///< listed; the totals count all

  int64_t num_places = 0;     ///< stretches that were skipped
  int64_t bytes_skipped = 0;  ///< in all stretches
  int64_t events_lost = 0;    ///< by gaps of the event number across stretches
  int64_t events_mended = 0;  ///< whose header was damaged, and that were read all the same
  bool truncated = false;     ///< the file ends inside an event; counted in the above
  std::string read_error;     ///< why the system refused to read on; empty: it did not
  std::vector<Place> places;  ///< skipped and mended, in the order of the file

  [[nodiscard]] bool any() const {
    return num_places > 0 || events_mended > 0 || !read_error.empty();
  }
  /// One sentence for people.
  [[nodiscard]] std::string Describe() const;
};

}  // namespace vantage
