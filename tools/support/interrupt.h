#pragma once

#include <csignal>
#include <stop_token>
#include <string>

namespace vantage {

/// Exit code of a program that was asked to end before all was done.
inline constexpr int kInterrupted = 130;

/// Turns SIGINT and SIGTERM into a stop request; a second one ends the program at once. Made before
/// any thread.
class Interrupt {
 public:
  /// @param what the program yet finishes: "the sequences in work".
  explicit Interrupt(const std::string& what);
  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }

 private:
  std::stop_source source_;
};

}  // namespace vantage
