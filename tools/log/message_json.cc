#include "tools/log/message_json.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace vantage {
namespace {

using Json = nlohmann::ordered_json;

bool IsBytes(const SchemaField& field) { return field.is_array && field.kind == FieldKind::kByte; }

Json NumberAt(const FieldNumbers& numbers, size_t i) {
  if (numbers.kind() == FieldKind::kBool) return numbers.Integer(i) != 0;
  if (!numbers.is_real()) return numbers.Integer(i);
  const double value = numbers.Real(i);
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json JsonFromNumbers(const SchemaField& field, const FieldNumbers& numbers) {
  if (IsBytes(field)) return Base64(numbers.bytes());
  if (!field.is_array) return NumberAt(numbers, 0);
  Json list = Json::array();
  for (size_t i = 0; i < numbers.size(); ++i) list.push_back(NumberAt(numbers, i));
  return list;
}

Json SchemaOfElement(const SchemaField& field) {
  switch (field.kind) {
    case FieldKind::kNested:
      return JsonSchemaOf(*field.nested);
    case FieldKind::kString:
      return {{"type", "string"}};
    case FieldKind::kBool:
      return {{"type", "boolean"}};
    case FieldKind::kFloat:
    case FieldKind::kDouble:
      return {{"type", "number"}};
    default:
      return {{"type", "integer"}};
  }
}

}  // namespace

Json JsonFromMessage(MessageFields fields) {
  using Event = MessageFields::Event;
  Json root = Json::object();
  std::vector<Json*> open = {&root};
  // Puts a value where the walk is. Pointers into an array stay good: only its last element is
  // open.
  const auto put = [&open, &fields](Json value) -> Json* {
    Json& place = *open.back();
    if (place.is_array()) {
      place.push_back(std::move(value));
      return &place.back();
    }
    return &(place[std::string(fields.field().name)] = std::move(value));
  };
  for (Event event = fields.Next(); event != Event::kEnd; event = fields.Next()) {
    switch (event) {
      case Event::kBeginStruct:
        open.push_back(put(Json::object()));
        break;
      case Event::kBeginArray:
        open.push_back(put(Json::array()));
        break;
      case Event::kEndStruct:
      case Event::kEndArray:
        open.pop_back();
        break;
      case Event::kNumbers:
        put(JsonFromNumbers(fields.field(), fields.numbers()));
        break;
      case Event::kText:
        put(std::string(fields.text()));
        break;
      case Event::kEnd:
        break;
    }
  }
  return root;
}

Json JsonSchemaOf(const MessageSchema& schema) {
  Json properties = Json::object();
  Json required = Json::array();
  for (const SchemaField& field : schema.fields) {
    const std::string name(field.name);
    required.push_back(name);
    if (IsBytes(field)) {
      properties[name] = {{"type", "string"}, {"contentEncoding", "base64"}};
    } else if (field.is_array) {
      properties[name] = {{"type", "array"}, {"items", SchemaOfElement(field)}};
    } else {
      properties[name] = SchemaOfElement(field);
    }
  }
  return {{"title", "vantage." + std::string(schema.name)},
          {"type", "object"},
          {"properties", properties},
          {"required", required}};
}

std::string JsonText(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string Base64(std::span<const std::byte> bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t count = std::min<size_t>(3, bytes.size() - i);
    uint32_t group = 0;
    for (size_t j = 0; j < 3; ++j) {
      group = (group << 8U) | (j < count ? std::to_integer<uint32_t>(bytes[i + j]) : 0U);
    }
    for (size_t j = 0; j < 4; ++j) {
      text += j <= count ? kDigits[(group >> (18U - 6U * j)) & 63U] : '=';
    }
  }
  return text;
}

}  // namespace vantage
