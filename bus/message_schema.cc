#include "bus/message_schema.h"

#include <algorithm>

namespace vantage {

const MessageSchema* FindSchema(std::string_view type_name) {
  const std::span<const MessageSchema> all = AllSchemas();
  const auto found = std::ranges::lower_bound(all, type_name, {}, &MessageSchema::name);
  return found != all.end() && found->name == type_name ? &*found : nullptr;
}

const MessageSchema* FindSchema(int64_t fingerprint) {
  const std::span<const MessageSchema> all = AllSchemas();
  const auto found = std::ranges::find_if(all, [fingerprint](const MessageSchema& schema) {
    return schema.fingerprint() == fingerprint;
  });
  return found != all.end() ? &*found : nullptr;
}

}  // namespace vantage
