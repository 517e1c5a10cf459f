#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace vantage {

/// By how much two messages may differ and still say the same. Integers, texts and bytes must be
/// equal always.
struct ComparisonTolerance {
  double position_mm = 0.0;  ///< between positions (three numbers named ...trans)
  double angle_deg = 0.0;    ///< of the rotation between orientations (four named ...quat)
  double absolute = 0.0;     ///< of other numbers: |a - b| <= absolute + relative * |a|
  double relative = 0.0;
};

/// Where two messages differ.
struct FieldDifference {
  std::string path;   ///< "objects[2].peaks[0].quat"
  std::string first;  ///< the values
  std::string second;
  std::string size;  ///< "0.012 deg", "1.5 mm"; empty where it has none
};

/// What differs between two messages, but for the fields that depend on the wall clock.
struct MessageComparison {
  bool identical = true;     ///< bit for bit
  bool within = true;        ///< within the tolerances
  double position_mm = 0.0;  ///< largest differences
  double angle_deg = 0.0;
  double number = 0.0;                    ///< of other numbers
  std::optional<FieldDifference> beyond;  ///< the first field that is not within
};

/// Compares two encoded messages. q and -q are one orientation; NaN equals NaN alone. Where lists
/// differ in length, or types, that is the difference, and nothing behind it is looked at. What is
/// no sound message of ours is compared by its bytes.
/// @param first the recorded one, to which relative tolerances refer.
MessageComparison CompareMessages(std::span<const std::byte> first,
                                  std::span<const std::byte> second,
                                  const ComparisonTolerance& tolerance);

/// Fields that are not compared, in words.
extern const char* const kNotCompared;

}  // namespace vantage
