#include "tools/contingency/trial_units.h"

#include <charconv>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "common/format.h"
#include "common/rng.h"

namespace vantage {
namespace {

constexpr int kMostShards = 100'000;
constexpr uint64_t kRowStream = 17;  // Of random numbers, apart from those of trials.

// A whole number >= 0 that is all of the text.
std::optional<int> Number(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 0) return std::nullopt;
  return value;
}

// "17" or "100-140".
std::optional<std::pair<int, int>> Range(std::string_view text) {
  const size_t dash = text.find('-');
  const std::optional<int> first = Number(text.substr(0, dash));
  const std::optional<int> last =
      dash == std::string_view::npos ? first : Number(text.substr(dash + 1));
  if (!first || !last || *first > *last) return std::nullopt;
  return std::pair{*first, *last};
}

Result<std::vector<int32_t>> RandomRows(std::string_view text, int num_cells, uint64_t seed) {
  const std::optional<int> count = Number(text);
  if (!count || *count < 1 || *count > num_cells) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format(
            "--rows random:%.40s, expected 1 to %d of them", std::string(text).c_str(), num_cells)};
  }
  // Floyd's: every set of that size is as likely.
  Rng rng(seed, kRowStream);
  std::set<int32_t> rows;
  for (int last = num_cells - *count; last < num_cells; ++last) {
    const auto row = static_cast<int32_t>(rng.Below(static_cast<uint32_t>(last) + 1));
    rows.insert(rows.contains(row) ? last : row);
  }
  return std::vector<int32_t>(rows.begin(), rows.end());
}

}  // namespace

Result<Shard> ParseShard(const std::string& text) {
  const size_t slash = text.find('/');
  const std::optional<int> index = Number(std::string_view(text).substr(0, slash));
  const std::optional<int> count =
      slash == std::string::npos ? std::nullopt : Number(std::string_view(text).substr(slash + 1));
  if (!index || !count || *index < 1 || *index > *count || *count > kMostShards) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("--shard %.40s, expected I/N with I from 1 to N and N at most %d",
                        text.c_str(),
                        kMostShards)};
  }
  return Shard{*index, *count};
}

TrialUnits UnitsOf(const Shard& shard, const TrialUnits& all) {
  TrialUnits mine;
  const auto step = static_cast<size_t>(shard.count);
  for (size_t i = static_cast<size_t>(shard.index) - 1; i < all.size(); i += step) {
    if (i < all.directions.size()) {
      mine.directions.push_back(all.directions[i]);
    } else {
      mine.rows.push_back(all.rows[i - all.directions.size()]);
    }
  }
  return mine;
}

Result<std::vector<int32_t>> ParseRows(const std::string& text, int num_cells, uint64_t seed) {
  constexpr std::string_view kRandom = "random:";
  if (text.empty()) return std::vector<int32_t>();
  if (text.starts_with(kRandom)) {
    return RandomRows(std::string_view(text).substr(kRandom.size()), num_cells, seed);
  }
  std::set<int32_t> rows;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const auto range = Range(std::string_view(text).substr(begin, end - begin));
    if (!range || range->second >= num_cells) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("--rows %.40s: \"%.40s\", expected numbers or ranges like 100-140 below "
                          "%d, or random:COUNT",
                          text.c_str(),
                          text.substr(begin, end - begin).c_str(),
                          num_cells)};
    }
    for (int row = range->first; row <= range->second; ++row) rows.insert(row);
    begin = end + 1;
  }
  return std::vector<int32_t>(rows.begin(), rows.end());
}

std::string RangesText(const std::vector<int32_t>& numbers, size_t most) {
  std::string text;
  size_t parts = 0;
  for (size_t i = 0; i < numbers.size(); ++parts) {
    size_t last = i;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    if (parts == most) return text + Format(" and %zu more", numbers.size() - i);
    if (parts > 0) text += ", ";
    text += last == i ? Format("%d", numbers[i]) : Format("%d-%d", numbers[i], numbers[last]);
    i = last + 1;
  }
  return text;
}

}  // namespace vantage
