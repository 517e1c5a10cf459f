#include "fusion/confusion/contingency_file.h"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <system_error>

#include "common/check.h"
#include "common/format.h"
#include "fusion/confusion/contingency_content.h"

namespace vantage {
namespace {

// The file: magic, version, bytes of the content (both little endian), the content compressed by
// zlib, CRC-32 of all before it.
constexpr char kMagic[] = "VCONTING";
constexpr size_t kMagicBytes = 8;
constexpr uint32_t kVersion = 1;
constexpr size_t kHeaderBytes = kMagicBytes + 4 + 8;
constexpr size_t kChecksumBytes = 4;
constexpr size_t kMostBytes = size_t{1} << 30U;  // Of a file or its content.
constexpr size_t kHighestRatio = 1040;           // Deflate compresses no better.

void AppendFixed(uint64_t value, int num_bytes, std::string* bytes) {
  for (int i = 0; i < num_bytes; ++i) {
    bytes->push_back(static_cast<char>(static_cast<unsigned char>(value >> (8U * unsigned(i)))));
  }
}

uint64_t FixedAt(const std::string& bytes, size_t at, int num_bytes) {
  uint64_t value = 0;
  for (int i = num_bytes - 1; i >= 0; --i) {
    value = (value << 8U) | static_cast<unsigned char>(bytes[at + static_cast<size_t>(i)]);
  }
  return value;
}

uint32_t Checksum(const std::string& bytes, size_t count) {
  return static_cast<uint32_t>(
      crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), count));
}

Error Corrupt(const std::string& name, const std::string& what) {
  return {ErrorCode::kCorrupt, Format("%s %s", name.c_str(), what.c_str())};
}

// What is wrong outside the content; empty: nothing.
std::string FrameError(const std::string& bytes) {
  if (bytes.compare(0, kMagicBytes, kMagic) != 0) return "is not a contingency table";
  if (bytes.size() < kHeaderBytes + kChecksumBytes) {
    return Format("has %zu bytes, expected at least %zu: it is cut off",
                  bytes.size(),
                  kHeaderBytes + kChecksumBytes);
  }
  const auto version = static_cast<uint32_t>(FixedAt(bytes, kMagicBytes, 4));
  if (version == 0 || version > kVersion) {
    return Format("is of version %u, this program reads up to %u", version, kVersion);
  }
  const size_t end = bytes.size() - kChecksumBytes;
  if (Checksum(bytes, end) != FixedAt(bytes, end, 4)) {
    return "is damaged or cut off: its checksum differs";
  }
  const uint64_t content_bytes = FixedAt(bytes, kMagicBytes + 4, 8);
  if (content_bytes > std::min<uint64_t>(kMostBytes, bytes.size() * kHighestRatio)) {
    return Format("claims %ju bytes of content in %zu", uintmax_t{content_bytes}, bytes.size());
  }
  return {};
}

}  // namespace

std::string EncodeContingencyTable(const ContingencyTable& table) {
  const std::string content = EncodeContent(table);
  std::string bytes(kMagic, kMagicBytes);
  AppendFixed(kVersion, 4, &bytes);
  AppendFixed(content.size(), 8, &bytes);
  uLongf size = compressBound(content.size());
  bytes.resize(kHeaderBytes + size);
  const int status = compress2(reinterpret_cast<unsigned char*>(bytes.data()) + kHeaderBytes,
                               &size,
                               reinterpret_cast<const unsigned char*>(content.data()),
                               content.size(),
                               Z_DEFAULT_COMPRESSION);
  VANTAGE_CHECK(status == Z_OK, "zlib compresses into a buffer of its bound");
  bytes.resize(kHeaderBytes + size);
  AppendFixed(Checksum(bytes, bytes.size()), 4, &bytes);
  return bytes;
}

Result<ContingencyTable> DecodeContingencyTable(const std::string& bytes, const std::string& name) {
  if (const std::string wrong = FrameError(bytes); !wrong.empty()) return Corrupt(name, wrong);
  const uint64_t expected = FixedAt(bytes, kMagicBytes + 4, 8);
  std::string content(expected, '\0');
  uLongf size = expected;
  const int status = uncompress(reinterpret_cast<unsigned char*>(content.data()),
                                &size,
                                reinterpret_cast<const unsigned char*>(bytes.data()) + kHeaderBytes,
                                bytes.size() - kHeaderBytes - kChecksumBytes);
  if (status != Z_OK || size != expected) {
    return Corrupt(name, Format("does not hold the %ju bytes it claims", uintmax_t{expected}));
  }
  ContingencyTable table;
  if (const std::string wrong = DecodeContent(content, &table); !wrong.empty()) {
    return Corrupt(name, wrong);
  }
  return table;
}

Result<void> WriteContingencyTable(const ContingencyTable& table,
                                   const std::filesystem::path& file) {
  const std::string bytes = EncodeContingencyTable(table);
  const std::filesystem::path part = file.string() + ".part";
  errno = 0;
  std::ofstream stream(part, std::ios::binary | std::ios::trunc);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  std::error_code error;
  if (stream) {
    std::filesystem::rename(part, file, error);
    if (!error) return {};
  } else {
    error = std::error_code(errno, std::generic_category());
  }
  const std::string reason = error.message();
  std::filesystem::remove(part, error);
  return Error{ErrorCode::kIo, Format("%s can't be written: %s", file.c_str(), reason.c_str())};
}

Result<ContingencyTable> ReadContingencyTable(const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) {
    return Error{ErrorCode::kNotFound,
                 Format("%s: no such file, expected a contingency table", file.c_str())};
  }
  if (!std::filesystem::is_regular_file(status)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s is not a file, expected a contingency table", file.c_str())};
  }
  const uintmax_t size = std::filesystem::file_size(file, error);
  if (error) {
    return Error{ErrorCode::kIo, Format("%s: %s", file.c_str(), error.message().c_str())};
  }
  if (size > kMostBytes) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s has %ju bytes, expected at most %zu", file.c_str(), size, kMostBytes)};
  }
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(static_cast<size_t>(size), '\0');
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size))) {
    return Error{ErrorCode::kIo,
                 Format("%s can't be read: %s", file.c_str(), std::strerror(errno))};
  }
  return DecodeContingencyTable(bytes, file.string());
}

Result<void> CheckContingencyKey(const ContingencyKey& table,
                                 const ContingencyKey& expected,
                                 const std::string& name) {
  ContingencyKey wanted = table;
  for (std::string ContingencyKey::*const member : {&ContingencyKey::model_id,
                                                    &ContingencyKey::mesh_hash,
                                                    &ContingencyKey::estimator,
                                                    &ContingencyKey::estimator_parameters,
                                                    &ContingencyKey::sensor}) {
    if (!(expected.*member).empty()) wanted.*member = expected.*member;
  }
  const std::string difference = table.DifferenceFrom(wanted);
  if (difference.empty()) return {};
  return Error{ErrorCode::kInvalidArgument,
               Format("%s is of another measurement: its %s", name.c_str(), difference.c_str())};
}

}  // namespace vantage
