#pragma once

#include <cstddef>
#include <vector>

#include "bus/message_schema.h"
#include "common/rng.h"

namespace vantage {

/// Encoded bytes of a sound message with random content: counts of 0 to `max_count`, strings of up
/// to 8 characters.
std::vector<std::byte> RandomMessage(const MessageSchema& schema, int max_count, Rng& rng);

}  // namespace vantage
