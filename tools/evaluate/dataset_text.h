#pragma once

#include <string>

#include "tools/evaluate/dataset_results.h"

namespace vantage {

/// Every outcome and every summary as tables for a terminal, after the datasets' notes.
std::string DatasetText(const DatasetResults& results);

/// A line an outcome (RFC 4180, first line names the columns): '\n' ends a line, numbers are the
/// shortest that read back as the same double, NaN is an empty field. Angles in degrees.
std::string DatasetCsv(const DatasetResults& results);

/// Command, bounds, summaries and outcomes with their poses (translation in m, quaternion w x y z)
/// as JSON. NaN is null.
std::string DatasetJson(const DatasetResults& results);

}  // namespace vantage
