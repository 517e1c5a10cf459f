#include "tools/support/message_comparison.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "bus/message_fields.h"
#include "common/format.h"
#include "common/so3.h"

namespace vantage {

const char* const kNotCompared = "compute_time of DETECTIONS_*, which is the wall clock's";

namespace {

using Event = MessageFields::Event;

bool SameBytes(std::span<const std::byte> a, std::span<const std::byte> b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size()) == 0);
}

template <size_t kSize>
std::optional<std::array<double, kSize>> Finite(const FieldNumbers& numbers) {
  std::array<double, kSize> values{};
  for (size_t i = 0; i < kSize; ++i) {
    values.at(i) = numbers.Real(i);
    if (!std::isfinite(values.at(i))) return std::nullopt;
  }
  return values;
}

std::optional<Eigen::Quaterniond> Orientation(const FieldNumbers& numbers) {
  const auto wxyz = Finite<4>(numbers);
  if (!wxyz) return std::nullopt;
  const Result<Eigen::Quaterniond> q = QuaternionFromWire(*wxyz);
  return q ? std::optional(*q) : std::nullopt;
}

std::string AllText(const FieldNumbers& numbers) {
  std::string text;
  for (size_t i = 0; i < numbers.size(); ++i) text += (i == 0 ? "" : ", ") + numbers.Text(i);
  return "[" + text + "]";
}

// A text of the wire for people: cut, without what a terminal would act on.
std::string Shown(std::string_view text) {
  constexpr size_t kLongest = 80;
  std::string shown = "'";
  for (const char c : text.substr(0, kLongest)) {
    shown += std::iscntrl(static_cast<unsigned char>(c)) != 0 ? '?' : c;
  }
  return shown + (text.size() > kLongest ? "...'" : "'");
}

class Comparer {
 public:
  Comparer(MessageFields first, MessageFields second, const ComparisonTolerance& tolerance)
      : first_(std::move(first)), second_(std::move(second)), tolerance_(tolerance) {}

  MessageComparison Run() {
    while (first_.Next() != Event::kEnd) {
      second_.Next();
      if (first_.event() == Event::kBeginArray && first_.array_size() != second_.array_size()) {
        Differ(true,
               first_.Path(),
               Format("%jd elements", intmax_t{first_.array_size()}),
               Format("%jd elements", intmax_t{second_.array_size()}));
        break;
      }
      if (first_.event() == Event::kText && first_.text() != second_.text()) {
        Differ(true, first_.Path(), Shown(first_.text()), Shown(second_.text()));
      }
      if (first_.event() == Event::kNumbers) Numbers(first_.numbers(), second_.numbers());
    }
    return std::move(result_);
  }

 private:
  void Differ(bool beyond,
              const std::string& path,
              const std::string& first,
              const std::string& second,
              const std::string& size = "") {
    result_.identical = false;
    if (!beyond) return;
    result_.within = false;
    if (!result_.beyond) result_.beyond = FieldDifference{path, first, second, size};
  }

  void Numbers(const FieldNumbers& a, const FieldNumbers& b) {
    if (SameBytes(a.bytes(), b.bytes()) || first_.field().name == "compute_time") return;
    if (a.size() != b.size()) {
      return Differ(
          true, first_.Path(), Format("%zu elements", a.size()), Format("%zu elements", b.size()));
    }
    const std::string_view name = first_.field().name;
    if (name.ends_with("quat") && a.size() == 4 && a.is_real() && Orientations(a, b)) return;
    if (name.ends_with("trans") && a.size() == 3 && a.is_real() && Positions(a, b)) return;
    for (size_t i = 0; i < a.size(); ++i) Number(a, b, i);
  }

  // False where they are none, as of a pose that is not known.
  bool Orientations(const FieldNumbers& a, const FieldNumbers& b) {
    const std::optional<Eigen::Quaterniond> q_a = Orientation(a);
    const std::optional<Eigen::Quaterniond> q_b = Orientation(b);
    if (!q_a || !q_b) return false;
    const double angle_deg = GeodesicAngle(*q_a, *q_b) / kDegree;
    result_.angle_deg = std::max(result_.angle_deg, angle_deg);
    Differ(angle_deg > tolerance_.angle_deg,
           first_.Path(),
           AllText(a),
           AllText(b),
           Format("%.3g deg", angle_deg));
    return true;
  }

  bool Positions(const FieldNumbers& a, const FieldNumbers& b) {
    const auto p_a = Finite<3>(a);
    const auto p_b = Finite<3>(b);
    if (!p_a || !p_b) return false;
    const double distance_mm =
        1e3 * std::hypot((*p_a)[0] - (*p_b)[0], (*p_a)[1] - (*p_b)[1], (*p_a)[2] - (*p_b)[2]);
    result_.position_mm = std::max(result_.position_mm, distance_mm);
    Differ(distance_mm > tolerance_.position_mm,
           first_.Path(),
           AllText(a),
           AllText(b),
           Format("%.3g mm", distance_mm));
    return true;
  }

  void Number(const FieldNumbers& a, const FieldNumbers& b, size_t i) {
    const auto width = static_cast<size_t>(WireSize(a.kind()));
    if (SameBytes(a.bytes().subspan(i * width, width), b.bytes().subspan(i * width, width))) return;
    bool beyond = true;
    if (a.is_real()) {
      const double value_a = a.Real(i);
      const double value_b = b.Real(i);
      const double difference = std::abs(value_a - value_b);
      // Of infinities and NaN only equal ones are equal.
      beyond = !(difference <= tolerance_.absolute + tolerance_.relative * std::abs(value_a));
      if (std::isnan(value_a) && std::isnan(value_b)) beyond = false;
      if (!std::isfinite(value_a) && !std::isnan(value_a)) beyond = value_a != value_b;
      if (std::isfinite(difference)) result_.number = std::max(result_.number, difference);
    }
    std::string path = beyond && !result_.beyond ? first_.Path() : "";
    if (first_.field().is_array) path += Format("[%zu]", i);
    Differ(beyond, path, a.Text(i), b.Text(i));
  }

  MessageFields first_;
  MessageFields second_;
  const ComparisonTolerance& tolerance_;
  MessageComparison result_;
};

MessageComparison Unequal(const std::string& path, std::string first, std::string second) {
  MessageComparison result;
  result.identical = result.within = false;
  result.beyond = FieldDifference{path, std::move(first), std::move(second), ""};
  return result;
}

}  // namespace

MessageComparison CompareMessages(std::span<const std::byte> first,
                                  std::span<const std::byte> second,
                                  const ComparisonTolerance& tolerance) {
  if (SameBytes(first, second)) return {};
  Result<MessageFields> a = MessageFields::Open(first);
  Result<MessageFields> b = MessageFields::Open(second);
  if (!a || !b) {
    const auto words = [](const Result<MessageFields>& fields, size_t size) {
      return fields ? Format("%zu bytes", size)
                    : Format("%zu bytes (%s)", size, fields.error().message.c_str());
    };
    return Unequal("the bytes", words(a, first.size()), words(b, second.size()));
  }
  if (a->schema().name != b->schema().name) {
    return Unequal("the type", std::string(a->schema().name), std::string(b->schema().name));
  }
  return Comparer(std::move(a).value(), std::move(b).value(), tolerance).Run();
}

}  // namespace vantage
