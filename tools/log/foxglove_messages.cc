#include "tools/log/foxglove_messages.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>

#include "bus/conversions.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "bus/wire.h"
#include "common/format.h"
#include "common/time_range.h"
#include "tools/log/color_picture.h"
#include "tools/log/message_json.h"
#include "tools/log/shown_text.h"
#include "vantage/next_view_t.hpp"
#include "vantage/object_estimates_v3_t.hpp"

namespace vantage {
namespace {

using Json = nlohmann::ordered_json;
using Messages = std::vector<FoxgloveMessage>;

static_assert(std::endian::native == std::endian::little, "16UC1 is written as it lies");

Json Time(int64_t utime) {
  const int64_t time = IsPlausibleUtime(utime) ? utime : 0;
  return {{"sec", time / 1'000'000}, {"nsec", time % 1'000'000 * 1000}};
}

Json Vector(const double (&v)[3]) { return {{"x", v[0]}, {"y", v[1]}, {"z", v[2]}}; }

// From the wire's w, x, y, z.
Json Quaternion(const double (&q)[4]) {
  return {{"x", q[1]}, {"y", q[2]}, {"z", q[3]}, {"w", q[0]}};
}

Json PoseOf(const double (&trans)[3], const double (&quat)[4]) {
  return {{"position", Vector(trans)}, {"orientation", Quaternion(quat)}};
}

template <class Values>
bool AllFinite(const Values& values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

Json RawImage(const std::string& frame,
              int64_t utime,
              int width,
              int height,
              const char* encoding,
              int bytes_per_pixel,
              std::span<const std::byte> data) {
  return {{"timestamp", Time(utime)},
          {"frame_id", frame},
          {"width", width},
          {"height", height},
          {"encoding", encoding},
          {"step", bytes_per_pixel * width},
          {"data", Base64(data)}};
}

Result<Messages> FromImages(const std::string& channel, const images_t& images) {
  Messages messages;
  const Result<DepthFrame> depth = DepthFrameFromMessage(images);
  if (depth) {
    std::vector<uint16_t> millimetres;
    for (const float metres : depth->image.depth) {
      millimetres.push_back(std::isfinite(metres)
                                ? static_cast<uint16_t>(std::lround(1000.0 * double{metres}))
                                : uint16_t{0});
    }
    messages.push_back({"/" + channel + "/depth",
                        "foxglove.RawImage",
                        RawImage(channel,
                                 images.utime,
                                 depth->image.width,
                                 depth->image.height,
                                 "16UC1",
                                 2,
                                 std::as_bytes(std::span(millimetres)))});
  } else if (depth.error().code != ErrorCode::kNotFound) {
    return depth.error();
  }
  const image_t* color = FindColor(images);
  if (color == nullptr) return messages;
  const std::string topic = "/" + channel + "/color";
  if (color->pixelformat == image_t::PIXEL_FORMAT_MJPEG) {
    messages.push_back({topic + "_jpeg",
                        "foxglove.CompressedImage",
                        {{"timestamp", Time(images.utime)},
                         {"frame_id", channel},
                         {"data", Base64(std::as_bytes(std::span(color->data)))},
                         {"format", "jpeg"}}});
    return messages;
  }
  const Result<RgbImage> picture = ColorPicture(*color);
  if (!picture) return picture.error();
  messages.push_back({topic,
                      "foxglove.RawImage",
                      RawImage(channel,
                               images.utime,
                               picture->width,
                               picture->height,
                               "rgb8",
                               3,
                               std::as_bytes(std::span(picture->rgb)))});
  return messages;
}

Result<Messages> FromInfo(const std::string& channel, const camera_info_t& info) {
  const std::string frame = channel.substr(0, channel.rfind("_INFO"));
  if (info.width < 0 || info.height < 0 ||
      !AllFinite(std::array{info.fx, info.fy, info.cx, info.cy})) {
    return Error{ErrorCode::kCorrupt, channel + " has a calibration that is none"};
  }
  const bool straight = info.distortion_model == "none";
  return Messages{{"/" + frame + "/calibration",
                   "foxglove.CameraCalibration",
                   {{"timestamp", Time(info.utime)},
                    {"frame_id", frame},
                    {"width", info.width},
                    {"height", info.height},
                    {"distortion_model", straight ? "" : "plumb_bob"},
                    {"D", straight ? std::vector<double>{} : info.distortion},
                    {"K", {info.fx, 0, info.cx, 0, info.fy, info.cy, 0, 0, 1}},
                    {"R", {1, 0, 0, 0, 1, 0, 0, 0, 1}},
                    {"P", {info.fx, 0, info.cx, 0, 0, info.fy, info.cy, 0, 0, 0, 1, 0}}}}};
}

// "CAMERA_XTION_TO_WORLD": the frame CAMERA_XTION in the frame "world".
Result<Messages> FromTransform(const std::string& channel, const rigid_transform_t& transform) {
  constexpr std::string_view kTo = "_TO_";
  const size_t to = channel.rfind(kTo);
  const Result<Pose> pose = PoseFromMessage(transform);
  if (!pose) return pose.error();
  if (to == std::string::npos) return Messages{};
  std::string parent = channel.substr(to + kTo.size());
  std::ranges::transform(parent, parent.begin(), [](unsigned char c) { return std::tolower(c); });
  return Messages{{"/tf",
                   "foxglove.FrameTransform",
                   {{"timestamp", Time(transform.utime)},
                    {"parent_frame_id", parent},
                    {"child_frame_id", channel.substr(0, to)},
                    {"translation", Vector(transform.trans)},
                    {"rotation", Quaternion(transform.quat)}}}};
}

Json Arrow(const Json& pose, const std::array<double, 3>& color) {
  return {{"pose", pose},
          {"shaft_length", 0.05},
          {"shaft_diameter", 0.004},
          {"head_length", 0.012},
          {"head_diameter", 0.008},
          {"color", {{"r", color[0]}, {"g", color[1]}, {"b", color[2]}, {"a", 1.0}}}};
}

// The object's axes, x red, y green, z blue, and its name.
Json Entity(const object_estimate_v3_t& object, int64_t utime) {
  const Eigen::Quaterniond q(object.refined_quat[0],
                             object.refined_quat[1],
                             object.refined_quat[2],
                             object.refined_quat[3]);
  Json arrows = Json::array();
  const std::array<Eigen::Vector3d, 3> axes = {
      Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()};
  for (size_t i = 0; i < 3; ++i) {
    const Eigen::Quaterniond turned =
        q * Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitX(), axes[i]);
    const double wire[4] = {turned.w(), turned.x(), turned.y(), turned.z()};
    arrows.push_back(Arrow(PoseOf(object.refined_trans, wire),
                           {i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0}));
  }
  const Json none = Json::array();
  const Json text = {{"pose", PoseOf(object.refined_trans, {1.0, 0.0, 0.0, 0.0})},
                     {"billboard", true},
                     {"font_size", 14.0},
                     {"scale_invariant", true},
                     {"color", {{"r", 1.0}, {"g", 1.0}, {"b", 1.0}, {"a", 1.0}}},
                     {"text", object.model_id}};
  return {{"timestamp", Time(utime)},
          {"frame_id", "world"},
          {"id", Format("%d", object.instance_id)},
          {"lifetime", {{"sec", 0}, {"nsec", 0}}},
          {"frame_locked", true},
          {"metadata",
           {{{"key", "model"}, {"value", object.model_id}},
            {{"key", "views"}, {"value", Format("%d", object.num_views)}},
            {{"key", "converged"}, {"value", object.converged != 0 ? "yes" : "no"}}}},
          {"arrows", arrows},
          {"cubes", none},
          {"spheres", none},
          {"cylinders", none},
          {"lines", none},
          {"triangles", none},
          {"texts", {text}},
          {"models", none}};
}

Result<Messages> FromObjects(const std::string& channel, const object_estimates_v3_t& objects) {
  Json entities = Json::array();
  for (const object_estimate_v3_t& object : objects.objects) {
    if (!AllFinite(object.refined_trans) || !AllFinite(object.refined_quat)) {
      return Error{ErrorCode::kCorrupt, channel + " has a pose that is not finite"};
    }
    if (object.state != object_estimate_v3_t::LOST) {
      entities.push_back(Entity(object, objects.utime));
    }
  }
  // What is not there any more goes.
  const Json all = {{"timestamp", Time(objects.utime)}, {"type", 1}, {"id", ""}};
  return Messages{{"/" + channel + "/scene",
                   "foxglove.SceneUpdate",
                   {{"deletions", {all}}, {"entities", entities}}}};
}

template <class Poses>
Result<Messages> FromPoses(const std::string& channel,
                           int64_t utime,
                           const std::string& frame,
                           const Poses& each) {
  Json poses = Json::array();
  for (const auto& one : each) {
    if (!AllFinite(one.trans) || !AllFinite(one.quat)) {
      return Error{ErrorCode::kCorrupt, channel + " has a pose that is not finite"};
    }
    poses.push_back(PoseOf(one.trans, one.quat));
  }
  return Messages{{"/" + channel + "/poses",
                   "foxglove.PosesInFrame",
                   {{"timestamp", Time(utime)}, {"frame_id", frame}, {"poses", poses}}}};
}

// `make` of the message, if the event is of the type.
template <class Message, class Make>
bool TryType(const LogEventView& event, Result<Messages>* result, const Make& make) {
  if (LoadBigEndian<int64_t>(event.data) != Message::getHash()) return false;
  const Result<Message> message = DecodeChecked<Message>(event.data);
  *result = message ? make(*message) : Result<Messages>(message.error());
  return true;
}

}  // namespace

Result<Messages> FoxgloveMessages(const LogEventView& event) {
  Result<Messages> made = Messages{};
  if (event.data.size() < sizeof(int64_t)) return made;
  const std::string channel = Printable(event.channel);  // JSON and topics are UTF-8.
  const bool is_hand = channel == "NEXT_HAND_POSE";
  static_cast<void>(
      TryType<images_t>(event, &made, [&](const images_t& m) { return FromImages(channel, m); }) ||
      TryType<camera_info_t>(
          event, &made, [&](const camera_info_t& m) { return FromInfo(channel, m); }) ||
      TryType<rigid_transform_t>(
          event, &made, [&](const rigid_transform_t& m) { return FromTransform(channel, m); }) ||
      TryType<object_estimates_v3_t>(
          event, &made, [&](const object_estimates_v3_t& m) { return FromObjects(channel, m); }) ||
      TryType<detections_v2_t>(event,
                               &made,
                               [&](const detections_v2_t& m) {
                                 return FromPoses(
                                     channel, m.utime, "CAMERA_" + m.camera, m.detections);
                               }) ||
      TryType<next_view_t>(event, &made, [&](const next_view_t& m) {
        return FromPoses(channel, m.utime, is_hand ? "base" : "world", m.candidates);
      }));
  return made;
}

}  // namespace vantage
