#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/result.h"

namespace vantage {

/// Writes an MCAP file (https://mcap.dev/spec): messages in chunks through zstd, each with its
/// checksum and index, and a summary at the end. In memory are one chunk and the index of chunks.
/// Under a temporary name until it is complete.
class McapWriter {
 public:
  /// Errors: the system refuses.
  static Result<std::unique_ptr<McapWriter>> Create(const std::filesystem::path& file);
  /// Without Close() nothing is left behind.
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// @param text JSON schema. @return its number.
  uint16_t AddSchema(std::string_view name, std::string_view text);
  /// @param schema 0: none. @return its number. At most kMostChannels.
  uint16_t AddChannel(std::string_view topic, std::string_view encoding, uint16_t schema);
  /// Times in ns since the epoch. Errors: the system refuses.
  Result<void> Write(uint16_t channel,
                     uint64_t log_time,
                     uint64_t publish_time,
                     std::string_view data);
  /// Errors: the system refuses.
  Result<void> Close();

  static constexpr size_t kChunkBytes = size_t{1} << 20U;  ///< uncompressed; a message more
  static constexpr size_t kMostChannels = 60'000;

 private:
  struct Span {
    uint64_t first = 0;  // ns
    uint64_t last = 0;
    bool is_empty = true;
    void Add(uint64_t time);
  };
  using Index = std::map<uint16_t, std::vector<std::pair<uint64_t, uint64_t>>>;

  McapWriter(std::filesystem::path file, std::filesystem::path temporary, std::FILE* stream);
  Result<void> Put(std::string_view bytes);
  Result<void> EndChunk();
  Result<void> PutSummary();
  [[nodiscard]] Error Refused() const;

  std::filesystem::path file_;
  std::filesystem::path temporary_;
  std::FILE* stream_;
  uint64_t offset_ = 0;  // Bytes written.
  uint32_t crc_ = 0;     // Of these, from where it was set to 0.

  std::string schemas_;   // Records, as they go into the summary.
  std::string channels_;  // The same.
  uint16_t num_schemas_ = 0;
  std::vector<uint64_t> counts_;  // Messages by channel, from 1.

  std::string chunk_;  // Records.
  Span chunk_span_;
  Index chunk_index_;          // Time and place in the chunk of its messages, by channel.
  std::string chunk_indices_;  // Records.
  uint32_t num_chunks_ = 0;
  Span span_;
};

}  // namespace vantage
