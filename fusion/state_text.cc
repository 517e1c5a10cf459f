#include "fusion/state_text.h"

#include <cmath>
#include <cstdlib>

#include "common/format.h"

namespace vantage {
namespace {

bool IsSpace(char c) { return c == ' ' || c == '\n'; }

}  // namespace

std::string FormatReal(double value) { return Format("%a", value); }

std::string FormatName(const std::string& name) { return Format("%zu:", name.size()) + name; }

std::string FormatPose(const Pose& pose) {
  std::string text;
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 4; ++column) {
      text.append(" ").append(FormatReal(pose.matrix()(row, column)));
    }
  }
  return text;
}

void StateReader::Keyword(std::string_view keyword) {
  if (Word() != keyword) Fail(Format("\"%s\"", std::string(keyword).c_str()));
}

size_t StateReader::Count() {
  return static_cast<size_t>(Number<int64_t>(0, static_cast<int64_t>(text_.size())));
}

double StateReader::Real() {
  const std::string word(Word());
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  if (word.empty() || *end != '\0' || !std::isfinite(value)) {
    Fail("a finite number");
    return 0.0;
  }
  return value;
}

std::string StateReader::Name() {
  if (failed()) return {};
  SkipSpace();
  const size_t colon = text_.find(':', position_);
  if (colon != std::string_view::npos) {
    size_t length = 0;
    const char* const begin = text_.data() + position_;
    const auto [end, error] = std::from_chars(begin, text_.data() + colon, length);
    if (error == std::errc() && end == text_.data() + colon && length <= text_.size() - colon - 1) {
      position_ = colon + 1 + length;
      return std::string(text_.substr(colon + 1, length));
    }
  }
  Fail("a name with its length");
  return {};
}

Pose StateReader::RigidPose() {
  Pose pose = Pose::Identity();
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 4; ++column) pose.matrix()(row, column) = Real();
  }
  const Eigen::Matrix3d R = pose.linear();
  const Eigen::Matrix3d excess = R * R.transpose() - Eigen::Matrix3d::Identity();
  if (!(excess.cwiseAbs().maxCoeff() < 1e-3 && R.determinant() > 0.0)) Fail("a rigid transform");
  return pose;
}

std::string StateReader::Rest() {
  SkipSpace();
  std::string rest(text_.substr(position_));
  position_ = text_.size();
  return rest;
}

void StateReader::End() {
  SkipSpace();
  if (position_ != text_.size()) Fail("the end");
}

void StateReader::Fail(const std::string& expected) {
  if (failed()) return;
  size_t line = 1;
  for (size_t i = 0; i < position_ && i < text_.size(); ++i) line += text_[i] == '\n' ? 1 : 0;
  error_ = Format("line %zu: expected %s", line, expected.c_str());
}

void StateReader::SkipSpace() {
  while (position_ < text_.size() && IsSpace(text_[position_])) ++position_;
}

std::string_view StateReader::Word() {
  if (failed()) return {};
  SkipSpace();
  const size_t begin = position_;
  while (position_ < text_.size() && !IsSpace(text_[position_])) ++position_;
  return text_.substr(begin, position_ - begin);
}

}  // namespace vantage
