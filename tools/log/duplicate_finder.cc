#include "tools/log/duplicate_finder.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "tools/support/hash.h"

namespace vantage {
namespace {

// Messages are taken for the same by this alone: of the thousands in a window no two others meet.
uint64_t HashOf(const LogEventView& event) {
  const std::string_view data(reinterpret_cast<const char*>(event.data.data()), event.data.size());
  return MixBits(Fnv1a(data, Fnv1a(event.channel)) ^ MixBits(event.data.size()));
}

// us, as far as times may be apart.
double Apart(int64_t a, int64_t b) {
  return std::abs(static_cast<double>(a) - static_cast<double>(b));
}

}  // namespace

bool DuplicateFinder::IsDuplicate(const LogEventView& event, size_t source) {
  Forget(event.utime);
  const uint64_t hash = HashOf(event);
  std::deque<Kept>& same = kept_[hash];
  for (Kept& kept : same) {
    if (std::ranges::find(kept.sources, source) != kept.sources.end()) continue;
    kept.sources.push_back(source);
    return true;
  }
  same.push_back({.utime = event.utime, .sources = {source}});
  expiries_.push_back({.utime = event.utime, .hash = hash});
  return false;
}

void DuplicateFinder::Forget(int64_t now_utime) {
  while (!expiries_.empty() && Apart(now_utime, expiries_.front().utime) > kWindow) {
    const auto entry = kept_.find(expiries_.front().hash);
    entry->second.pop_front();
    if (entry->second.empty()) kept_.erase(entry);
    expiries_.pop_front();
  }
}

}  // namespace vantage
