#include "common/check.h"
#include "tools/log/foxglove_messages.h"

namespace vantage {
namespace {

using Json = nlohmann::ordered_json;

Json Object(const char* title, const Json& properties) {
  Json schema = {{"title", title}, {"type", "object"}, {"properties", properties}};
  Json required = Json::array();
  for (const auto& property : properties.items()) required.push_back(property.key());
  schema["required"] = required;
  return schema;
}

Json ListOf(const Json& items) { return {{"type", "array"}, {"items", items}}; }

Json Numbers(int count) {
  Json list = ListOf({{"type", "number"}});
  list["minItems"] = count;
  list["maxItems"] = count;
  return list;
}

Json Text() { return {{"type", "string"}}; }
Json Number() { return {{"type", "number"}}; }
Json Integer() { return {{"type", "integer"}}; }
Json Bool() { return {{"type", "boolean"}}; }
Json Base64Text() { return {{"type", "string"}, {"contentEncoding", "base64"}}; }

Json TimeSchema(const char* title) {
  return Object(title, {{"sec", Integer()}, {"nsec", Integer()}});
}
Json Time() { return TimeSchema("time"); }

Json Vector() {
  return Object("foxglove.Vector3", {{"x", Number()}, {"y", Number()}, {"z", Number()}});
}
Json Quaternion() {
  return Object("foxglove.Quaternion",
                {{"x", Number()}, {"y", Number()}, {"z", Number()}, {"w", Number()}});
}
Json PoseSchema() {
  return Object("foxglove.Pose", {{"position", Vector()}, {"orientation", Quaternion()}});
}
Json Color() {
  return Object("foxglove.Color",
                {{"r", Number()}, {"g", Number()}, {"b", Number()}, {"a", Number()}});
}

Json ArrowSchema() {
  return Object("foxglove.ArrowPrimitive",
                {{"pose", PoseSchema()},
                 {"shaft_length", Number()},
                 {"shaft_diameter", Number()},
                 {"head_length", Number()},
                 {"head_diameter", Number()},
                 {"color", Color()}});
}

Json TextSchema() {
  return Object("foxglove.TextPrimitive",
                {{"pose", PoseSchema()},
                 {"billboard", Bool()},
                 {"font_size", Number()},
                 {"scale_invariant", Bool()},
                 {"color", Color()},
                 {"text", Text()}});
}

Json SceneSchema() {
  const Json pair = Object("foxglove.KeyValuePair", {{"key", Text()}, {"value", Text()}});
  // Kinds of which there are none here.
  const Json none = ListOf(Json{{"type", "object"}, {"properties", Json::object()}});
  const Json entity = Object("foxglove.SceneEntity",
                             {{"timestamp", Time()},
                              {"frame_id", Text()},
                              {"id", Text()},
                              {"lifetime", TimeSchema("duration")},
                              {"frame_locked", Bool()},
                              {"metadata", ListOf(pair)},
                              {"arrows", ListOf(ArrowSchema())},
                              {"cubes", none},
                              {"spheres", none},
                              {"cylinders", none},
                              {"lines", none},
                              {"triangles", none},
                              {"texts", ListOf(TextSchema())},
                              {"models", none}});
  const Json deletion = Object("foxglove.SceneEntityDeletion",
                               {{"timestamp", Time()}, {"type", Integer()}, {"id", Text()}});
  return Object("foxglove.SceneUpdate",
                {{"deletions", ListOf(deletion)}, {"entities", ListOf(entity)}});
}

}  // namespace

Json FoxgloveSchema(const std::string& name) {
  if (name == "foxglove.RawImage") {
    return Object("foxglove.RawImage",
                  {{"timestamp", Time()},
                   {"frame_id", Text()},
                   {"width", Integer()},
                   {"height", Integer()},
                   {"encoding", Text()},
                   {"step", Integer()},
                   {"data", Base64Text()}});
  }
  if (name == "foxglove.CompressedImage") {
    return Object(
        "foxglove.CompressedImage",
        {{"timestamp", Time()}, {"frame_id", Text()}, {"data", Base64Text()}, {"format", Text()}});
  }
  if (name == "foxglove.CameraCalibration") {
    return Object("foxglove.CameraCalibration",
                  {{"timestamp", Time()},
                   {"frame_id", Text()},
                   {"width", Integer()},
                   {"height", Integer()},
                   {"distortion_model", Text()},
                   {"D", ListOf(Number())},
                   {"K", Numbers(9)},
                   {"R", Numbers(9)},
                   {"P", Numbers(12)}});
  }
  if (name == "foxglove.FrameTransform") {
    return Object("foxglove.FrameTransform",
                  {{"timestamp", Time()},
                   {"parent_frame_id", Text()},
                   {"child_frame_id", Text()},
                   {"translation", Vector()},
                   {"rotation", Quaternion()}});
  }
  if (name == "foxglove.PosesInFrame") {
    return Object("foxglove.PosesInFrame",
                  {{"timestamp", Time()}, {"frame_id", Text()}, {"poses", ListOf(PoseSchema())}});
  }
  VANTAGE_CHECK(name == "foxglove.SceneUpdate", name);
  return SceneSchema();
}

}  // namespace vantage
