#pragma once

#include <cstdint>
#include <string>

namespace vantage {

/// Parameters as lines of text: a name, then values with blanks between. Numbers are the shortest
/// that read back as the same number, so equal texts mean equal parameters.
class ParameterText {
 public:
  template <class... Values>
  void Line(const char* name, const Values&... values) {
    text_ += name;
    (Add(values), ...);
    text_ += '\n';
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  void Add(const std::string& value);
  void Add(bool value);
  void Add(int value);
  void Add(uint64_t value);
  void Add(double value);

  std::string text_;
};

}  // namespace vantage
