#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "common/result.h"
#include "fusion/confusion/contingency_table.h"

namespace vantage {

/// The bytes of a table: magic "VCONTING", version, key, entries, compressed, with checksum.
/// Equal tables give equal bytes.
std::string EncodeContingencyTable(const ContingencyTable& table);
/// Errors: foreign, of a later version, truncated, damaged, counts that do not add up; `name`
/// stands for the source in messages.
Result<ContingencyTable> DecodeContingencyTable(const std::string& bytes, const std::string& name);

/// Whole or not at all.
Result<void> WriteContingencyTable(const ContingencyTable& table,
                                   const std::filesystem::path& file);
Result<ContingencyTable> ReadContingencyTable(const std::filesystem::path& file);

/// Error when a table is not of this model or estimator: names both values. Empty strings of
/// `expected` are not compared (nor are num_directions, rows_k, seed and stopping).
Result<void> CheckContingencyKey(const ContingencyKey& table,
                                 const ContingencyKey& expected,
                                 const std::string& name);

}  // namespace vantage
