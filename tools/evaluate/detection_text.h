#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "common/result.h"
#include "tools/evaluate/detection_sequence.h"

namespace vantage {

/// Appends a sequence as text:
///   sequence INDEX, number of views, T_world_object
///   view     T_world_camera                                      for each view, and below it
///   found    cluster, T_camera_object, mse, inlier_fraction, verification_score    for each
///   hypothesis end      FNV-1a of all that, in hexadecimal
/// A transform is its first three rows, row by row, m. Every number reads back as the same number.
void AppendSequenceText(const DetectionSequence& sequence, std::string* text);

/// A sequence's text from `text`'s begin on.
struct SequenceText {
  std::string_view record;  ///< with its line "end"
  bool is_whole = false;    ///< it has one and the checksum agrees
};
/// `text` is not empty. What is not whole reaches to where the next record begins, or to the end.
SequenceText FirstSequenceText(std::string_view text);

/// The content of a whole record; model ids are left empty.
/// Errors: what AppendSequenceText would not have written, values out of range. The message says
/// what is wrong with the record's line number `line`, from 0.
Result<DetectionSequence> ParseSequenceText(std::string_view record, size_t* line);

}  // namespace vantage
