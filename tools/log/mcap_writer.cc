#include "tools/log/mcap_writer.h"

#include <unistd.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>

#include "common/check.h"
#include "common/format.h"

namespace vantage {
namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr const char* kCompression = "zstd";
constexpr int kLevel = 3;

enum class Op : uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

// A record's content, little-endian.
class Record {
 public:
  explicit Record(Op op) : op_(op) {}

  template <class Unsigned>
  Record& Add(Unsigned value) {
    static_assert(std::endian::native == std::endian::little);
    content_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Record& AddText(std::string_view text) {
    return Add(static_cast<uint32_t>(text.size())).AddRaw(text);
  }
  Record& AddRaw(std::string_view bytes) {
    content_.append(bytes);
    return *this;
  }
  [[nodiscard]] const std::string& content() const { return content_; }
  void AppendTo(std::string* bytes) const {
    bytes->push_back(static_cast<char>(op_));
    const uint64_t size = content_.size();
    bytes->append(reinterpret_cast<const char*>(&size), sizeof size);
    bytes->append(content_);
  }
  [[nodiscard]] std::string Bytes() const {
    std::string bytes;
    AppendTo(&bytes);
    return bytes;
  }

 private:
  Op op_;
  std::string content_;
};

uint32_t Crc(uint32_t crc, std::string_view bytes) {
  return static_cast<uint32_t>(
      crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::string Compress(const std::string& bytes) {
  std::string compressed(ZSTD_compressBound(bytes.size()), '\0');
  const size_t size =
      ZSTD_compress(compressed.data(), compressed.size(), bytes.data(), bytes.size(), kLevel);
  VANTAGE_CHECK(ZSTD_isError(size) == 0, "zstd refuses a buffer of its own bound");
  compressed.resize(size);
  return compressed;
}

}  // namespace

void McapWriter::Span::Add(uint64_t time) {
  first = is_empty ? time : std::min(first, time);
  last = is_empty ? time : std::max(last, time);
  is_empty = false;
}

McapWriter::McapWriter(std::filesystem::path file,
                       std::filesystem::path temporary,
                       std::FILE* stream)
    : file_(std::move(file)), temporary_(std::move(temporary)), stream_(stream) {}

Result<std::unique_ptr<McapWriter>> McapWriter::Create(const std::filesystem::path& file) {
  const std::filesystem::path temporary = file.string() + Format(".partial-%d", getpid());
  std::FILE* stream = std::fopen(temporary.c_str(), "wbe");
  std::unique_ptr<McapWriter> writer(new McapWriter(file, temporary, stream));
  if (stream == nullptr) return writer->Refused();
  std::string start(kMagic);
  Record(Op::kHeader).AddText("").AddText("vantage " VANTAGE_VERSION).AppendTo(&start);
  if (Result<void> put = writer->Put(start); !put) return put.error();
  return writer;
}

McapWriter::~McapWriter() {
  if (stream_ == nullptr) return;
  std::fclose(stream_);
  unlink(temporary_.c_str());
}

uint16_t McapWriter::AddSchema(std::string_view name, std::string_view text) {
  const std::string record = Record(Op::kSchema)
                                 .Add(++num_schemas_)
                                 .AddText(name)
                                 .AddText("jsonschema")
                                 .AddText(text)
                                 .Bytes();
  schemas_ += record;
  chunk_ += record;
  return num_schemas_;
}

uint16_t McapWriter::AddChannel(std::string_view topic,
                                std::string_view encoding,
                                uint16_t schema) {
  VANTAGE_CHECK(counts_.size() < kMostChannels, topic);
  counts_.push_back(0);
  const auto number = static_cast<uint16_t>(counts_.size());
  const std::string record = Record(Op::kChannel)
                                 .Add(number)
                                 .Add(schema)
                                 .AddText(topic)
                                 .AddText(encoding)
                                 .Add(uint32_t{0})  // No metadata.
                                 .Bytes();
  channels_ += record;
  chunk_ += record;
  return number;
}

Result<void> McapWriter::Write(uint16_t channel,
                               uint64_t log_time,
                               uint64_t publish_time,
                               std::string_view data) {
  chunk_index_[channel].emplace_back(log_time, chunk_.size());
  const uint64_t sequence = counts_.at(channel - 1U)++;
  Record(Op::kMessage)
      .Add(channel)
      .Add(static_cast<uint32_t>(sequence))
      .Add(log_time)
      .Add(publish_time)
      .AddRaw(data)
      .AppendTo(&chunk_);
  chunk_span_.Add(log_time);
  span_.Add(log_time);
  if (chunk_.size() < kChunkBytes) return {};
  return EndChunk();
}

Result<void> McapWriter::EndChunk() {
  if (chunk_.empty()) return {};
  const std::string compressed = Compress(chunk_);
  const std::string record = Record(Op::kChunk)
                                 .Add(chunk_span_.first)
                                 .Add(chunk_span_.last)
                                 .Add(uint64_t{chunk_.size()})
                                 .Add(Crc(0, chunk_))
                                 .AddText(kCompression)
                                 .Add(uint64_t{compressed.size()})
                                 .AddRaw(compressed)
                                 .Bytes();
  const uint64_t chunk_start = offset_;
  if (Result<void> put = Put(record); !put) return put;
  const uint64_t index_start = offset_;
  Record places(Op::kChunkIndex);  // For its content: channel and offset of each index.
  for (const auto& [channel, messages] : chunk_index_) {
    places.Add(channel).Add(offset_);
    Record entries(Op::kMessageIndex);
    for (const auto& [time, place] : messages) entries.Add(time).Add(place);
    const Record index = Record(Op::kMessageIndex).Add(channel).AddText(entries.content());
    if (Result<void> put = Put(index.Bytes()); !put) return put;
  }
  Record(Op::kChunkIndex)
      .Add(chunk_span_.first)
      .Add(chunk_span_.last)
      .Add(chunk_start)
      .Add(uint64_t{record.size()})
      .AddText(places.content())
      .Add(offset_ - index_start)
      .AddText(kCompression)
      .Add(uint64_t{compressed.size()})
      .Add(uint64_t{chunk_.size()})
      .AppendTo(&chunk_indices_);
  ++num_chunks_;
  chunk_.clear();
  chunk_span_ = {};
  chunk_index_.clear();
  return {};
}

Result<void> McapWriter::PutSummary() {
  Record counts(Op::kStatistics);  // For its content.
  uint64_t num_messages = 0;
  for (size_t i = 0; i < counts_.size(); ++i) {
    num_messages += counts_[i];
    counts.Add(static_cast<uint16_t>(i + 1)).Add(counts_[i]);
  }
  const std::string statistics = Record(Op::kStatistics)
                                     .Add(num_messages)
                                     .Add(num_schemas_)
                                     .Add(static_cast<uint32_t>(counts_.size()))
                                     .Add(uint32_t{0})  // Attachments.
                                     .Add(uint32_t{0})  // Metadata.
                                     .Add(num_chunks_)
                                     .Add(span_.first)
                                     .Add(span_.last)
                                     .AddText(counts.content())
                                     .Bytes();
  const uint64_t start = offset_;
  crc_ = 0;
  std::string offsets;
  for (const auto& [op, records] : {std::pair<Op, const std::string&>{Op::kSchema, schemas_},
                                    {Op::kChannel, channels_},
                                    {Op::kStatistics, statistics},
                                    {Op::kChunkIndex, chunk_indices_}}) {
    if (records.empty()) continue;
    Record(Op::kSummaryOffset)
        .Add(static_cast<uint8_t>(op))
        .Add(offset_)
        .Add(uint64_t{records.size()})
        .AppendTo(&offsets);
    if (Result<void> put = Put(records); !put) return put;
  }
  const uint64_t offsets_start = offset_;
  if (Result<void> put = Put(offsets); !put) return put;
  // The footer's own bytes up to the checksum are part of what it is over.
  Record footer(Op::kFooter);
  footer.Add(start).Add(offsets_start);
  std::string bytes(1, static_cast<char>(Op::kFooter));
  const uint64_t size = footer.content().size() + sizeof(uint32_t);
  bytes.append(reinterpret_cast<const char*>(&size), sizeof size);
  bytes += footer.content();
  footer.Add(Crc(crc_, bytes));
  return Put(footer.Bytes() + std::string(kMagic));
}

Result<void> McapWriter::Close() {
  VANTAGE_CHECK(stream_ != nullptr, "a closed MCAP file is closed again");
  if (Result<void> ended = EndChunk(); !ended) return ended;
  const Record end = Record(Op::kDataEnd).Add(crc_);
  if (Result<void> put = Put(end.Bytes()); !put) return put;
  if (Result<void> put = PutSummary(); !put) return put;
  const bool closed = std::fclose(std::exchange(stream_, nullptr)) == 0;
  if (closed && std::rename(temporary_.c_str(), file_.c_str()) == 0) return {};
  Error refused = Refused();
  unlink(temporary_.c_str());
  return refused;
}

Result<void> McapWriter::Put(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), stream_) != bytes.size()) return Refused();
  offset_ += bytes.size();
  crc_ = Crc(crc_, bytes);
  return {};
}

Error McapWriter::Refused() const {
  return {ErrorCode::kIo, Format("%s can't be written: %s", file_.c_str(), std::strerror(errno))};
}

}  // namespace vantage
