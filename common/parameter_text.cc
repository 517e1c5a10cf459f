#include "common/parameter_text.h"

#include <array>
#include <charconv>

namespace vantage {
namespace {

template <class Number>
void AppendNumber(Number value, std::string* text) {
  std::array<char, 32> digits{};
  *text += ' ';
  text->append(digits.data(),
               std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
}

}  // namespace

void ParameterText::Add(const std::string& value) {
  text_ += ' ';
  text_ += value;
}
void ParameterText::Add(bool value) { text_ += value ? " on" : " off"; }
void ParameterText::Add(int value) { AppendNumber(value, &text_); }
void ParameterText::Add(uint64_t value) { AppendNumber(value, &text_); }
void ParameterText::Add(double value) { AppendNumber(value, &text_); }

}  // namespace vantage
