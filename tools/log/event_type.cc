#include "tools/log/event_type.h"

#include "bus/message_schema.h"
#include "bus/wire.h"
#include "common/format.h"

namespace vantage {

std::optional<int64_t> Fingerprint(std::span<const std::byte> data) {
  if (data.size() < sizeof(int64_t)) return {};
  return LoadBigEndian<int64_t>(data);
}

void EventTypes::Add(int64_t fingerprint, const std::string& name) {
  if (learned_.size() < kMaxNames) learned_.emplace(fingerprint, name);
}

std::string EventTypes::Name(std::span<const std::byte> data) const {
  const std::optional<int64_t> fingerprint = Fingerprint(data);
  if (!fingerprint) return "(too short)";
  if (const MessageSchema* schema = FindSchema(*fingerprint)) return std::string(schema->name);
  const auto found = learned_.find(*fingerprint);
  if (found != learned_.end()) return found->second + " (unknown here)";
  return Format("%016jx", static_cast<uintmax_t>(*fingerprint));
}

}  // namespace vantage
