#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bus/event_log_reader.h"
#include "common/result.h"

namespace vantage {

/// A message of one of the schemas that Foxglove draws.
struct FoxgloveMessage {
  std::string topic;   ///< e.g. "/CAMERA_XTION/depth"
  std::string schema;  ///< e.g. "foxglove.RawImage"
  nlohmann::ordered_json content;
};

/// What a message of ours looks like to Foxglove: images as RawImage (16UC1, rgb8) or
/// CompressedImage, calibrations as CameraCalibration, rigid transforms as FrameTransform, objects
/// as SceneUpdate, detections and view candidates as PosesInFrame. Frames are "world", "base", and
/// the channels' names without suffix: "CAMERA_XTION". Nothing for other types.
/// Errors: the message is malformed, or says what can't be drawn.
Result<std::vector<FoxgloveMessage>> FoxgloveMessages(const LogEventView& event);

/// The JSON schema by that name.
nlohmann::ordered_json FoxgloveSchema(const std::string& name);

}  // namespace vantage
