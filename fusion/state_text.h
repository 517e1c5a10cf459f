#pragma once

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/so3.h"

namespace vantage {

// The text that states are saved as: words between spaces and line ends.

/// Hexadecimal floating point, which is exact.
std::string FormatReal(double value);
/// With its length in front, since names may hold any character.
std::string FormatName(const std::string& name);
/// Twelve reals, each with a space in front.
std::string FormatPose(const Pose& pose);

/// Takes a state's text apart. The first thing that is not as expected becomes error(); from then
/// on every answer is 0 or empty.
class StateReader {
 public:
  /// @param text outlives the reader.
  explicit StateReader(std::string_view text) : text_(text) {}

  void Keyword(std::string_view keyword);
  template <class Integer>
  Integer Number(Integer lowest, Integer highest);
  /// A count of records, each of which takes some of the text.
  size_t Count();
  double Real();  ///< finite
  std::string Name();
  Pose RigidPose();
  /// All that is left.
  std::string Rest();
  void End();

  /// For what the caller finds wrong. `expected` is what should have been there.
  void Fail(const std::string& expected);
  [[nodiscard]] bool failed() const { return !error_.empty(); }
  [[nodiscard]] const std::string& error() const { return error_; }

 private:
  void SkipSpace();
  std::string_view Word();

  std::string_view text_;
  size_t position_ = 0;
  std::string error_;
};

template <class Integer>
Integer StateReader::Number(Integer lowest, Integer highest) {
  const std::string_view word = Word();
  Integer value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || value < lowest ||
      value > highest) {
    Fail("a number in its range");
    return Integer{};
  }
  return value;
}

}  // namespace vantage
