#pragma once

#include <nlohmann/json.hpp>

#include "bus/message_fields.h"
#include "bus/message_schema.h"

namespace vantage {

/// A message as a JSON object with its members' names. Bytes become base64, numbers that are not
/// finite null.
nlohmann::ordered_json JsonFromMessage(MessageFields fields);

/// The JSON schema of what JsonFromMessage() makes of a type; every member is required.
nlohmann::ordered_json JsonSchemaOf(const MessageSchema& schema);

/// The text of a JSON value; bytes that are no UTF-8 are replaced.
std::string JsonText(const nlohmann::ordered_json& json);

/// RFC 4648, with padding.
std::string Base64(std::span<const std::byte> bytes);

}  // namespace vantage
