#pragma once

#include <string>

#include "fusion/confusion/contingency_table.h"

namespace vantage {

/// What a contingency file holds inside its frame: the key, then the trials by direction and the
/// rows, numbers in as few groups of seven bits as they need, ascending ones as differences.
std::string EncodeContent(const ContingencyTable& table);

/// The inverse, of bytes from anywhere. Returns what is wrong with them ("has a row with 6 outcomes
/// of 5 trials"); empty: nothing, and every count adds up.
std::string DecodeContent(const std::string& content, ContingencyTable* table);

}  // namespace vantage
