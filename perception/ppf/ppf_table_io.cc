#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numeric>
#include <system_error>

#include "common/format.h"
#include "perception/ppf/ppf_table.h"

namespace vantage {
namespace {

static_assert(std::endian::native == std::endian::little, "the file is little-endian");
static_assert(sizeof(PpfTable::Entry) == 4 && sizeof(SurfacePoint) == 24);

constexpr std::array<char, 8> kMagic = {'V', 'N', 'T', 'G', 'P', 'P', 'F', '2'};

// What precedes points, starts and entries in the file.
struct Header {
  std::array<char, 8> magic;
  uint64_t mesh_hash;
  double diameter;
  double sample_distance;
  double distance_step;
  double angle_step_deg;
  uint32_t max_points;
  uint32_t num_points;
  uint32_t num_starts;
  uint32_t num_entries;
  uint64_t checksum;  // Of the whole file, but for this.
};

template <class T>
std::span<const char> Bytes(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

template <class T>
std::span<char> WritableBytes(std::vector<T>& values) {
  return {reinterpret_cast<char*>(values.data()), values.size() * sizeof(T)};
}

// FNV-1a by words of 8 bytes, which is enough against damage and quick.
uint64_t Checksum(uint64_t hash, std::span<const char> bytes) {
  for (size_t i = 0; i < bytes.size(); i += 8) {
    uint64_t word = 0;
    std::memcpy(&word, bytes.data() + i, std::min<size_t>(8, bytes.size() - i));
    hash = (hash ^ word) * 0x100000001b3ULL;
    hash ^= hash >> 32U;
  }
  return hash;
}

uint64_t FileChecksum(Header header,
                      std::span<const char> points,
                      std::span<const char> starts,
                      std::span<const char> entries) {
  header.checksum = 0;
  uint64_t hash = 0xcbf29ce484222325ULL;
  hash = Checksum(hash, {reinterpret_cast<const char*>(&header), sizeof(header)});
  hash = Checksum(hash, points);
  hash = Checksum(hash, starts);
  return Checksum(hash, entries);
}

Error Corrupt(const std::filesystem::path& file, const std::string& why) {
  return Error{ErrorCode::kCorrupt,
               file.string() + ": " + why +
                   "; expected a matching table, which `vantage-model build` makes again"};
}

}  // namespace

Result<void> PpfTable::Save(const std::filesystem::path& file, uint64_t mesh_hash) const {
  Header header{kMagic,
                mesh_hash,
                diameter_,
                parameters_.sample_distance,
                parameters_.distance_step,
                parameters_.angle_step_deg,
                static_cast<uint32_t>(parameters_.max_points),
                static_cast<uint32_t>(points_.size()),
                static_cast<uint32_t>(starts_.size()),
                static_cast<uint32_t>(entries_.size()),
                0};
  header.checksum = FileChecksum(header, Bytes(points_), Bytes(starts_), Bytes(entries_));
  std::filesystem::path part = file;
  part += ".part";
  {
    errno = 0;
    std::ofstream stream(part, std::ios::binary | std::ios::trunc);
    stream.write(reinterpret_cast<const char*>(&header), sizeof(header));
    for (const std::span<const char> bytes : {Bytes(points_), Bytes(starts_), Bytes(entries_)}) {
      stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
    stream.flush();
    if (!stream) {
      const std::string reason = std::strerror(errno);
      std::error_code ignored;
      std::filesystem::remove(part, ignored);
      return Error{ErrorCode::kIo, file.string() + " can't be written: " + reason};
    }
  }
  std::error_code error;
  std::filesystem::rename(part, file, error);
  if (error) return Error{ErrorCode::kIo, file.string() + ": " + error.message()};
  return {};
}

Result<PpfTable> PpfTable::Load(const std::filesystem::path& file, uint64_t mesh_hash) {
  std::error_code error;
  const std::uintmax_t file_size = std::filesystem::file_size(file, error);
  if (error) return Error{ErrorCode::kNotFound, file.string() + ": " + error.message()};
  std::ifstream stream(file, std::ios::binary);
  Header header{};
  stream.read(reinterpret_cast<char*>(&header), sizeof(header));
  if (!stream || header.magic != kMagic) return Corrupt(file, "no matching table of this version");
  if (header.mesh_hash != mesh_hash) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s belongs to the mesh %016llx, expected %016llx",
                        file.c_str(),
                        static_cast<unsigned long long>(header.mesh_hash),
                        static_cast<unsigned long long>(mesh_hash))};
  }
  PpfTable table;
  table.parameters_.sample_distance = header.sample_distance;
  table.parameters_.distance_step = header.distance_step;
  table.parameters_.angle_step_deg = header.angle_step_deg;
  table.parameters_.max_points = static_cast<int>(std::min(header.max_points, 1U << 30U));
  if (Result<void> valid = table.parameters_.Validate(); !valid) {
    return Corrupt(file, valid.error().message);
  }
  table.diameter_ = header.diameter;
  if (!(table.diameter_ > 0.0 && table.diameter_ < 1e3)) return Corrupt(file, "its diameter");
  table.SetScale();
  // The sizes must be the file's before anything is allocated by them.
  const std::uintmax_t claimed = sizeof(Header) + std::uintmax_t{24} * header.num_points +
                                 std::uintmax_t{4} * header.num_starts +
                                 std::uintmax_t{4} * header.num_entries;
  if (claimed != file_size || header.num_starts != table.NumCells() + 1) {
    return Corrupt(file, "its counts differ from its size");
  }
  table.points_.resize(header.num_points);
  table.starts_.resize(header.num_starts);
  table.entries_.resize(header.num_entries);
  for (const std::span<char> bytes : {WritableBytes(table.points_),
                                      WritableBytes(table.starts_),
                                      WritableBytes(table.entries_)}) {
    stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }
  if (!stream) return Error{ErrorCode::kIo, file.string() + " can't be read"};
  const uint64_t checksum =
      FileChecksum(header, Bytes(table.points_), Bytes(table.starts_), Bytes(table.entries_));
  if (checksum != header.checksum) return Corrupt(file, "its checksum differs");
  if (Result<void> sound = table.CheckConsistent(); !sound) {
    return Corrupt(file, sound.error().message);
  }
  return table;
}

Result<void> PpfTable::CheckConsistent() const {
  const auto fail = [](const char* what) { return Error{ErrorCode::kCorrupt, what}; };
  if (points_.size() < 3 || points_.size() > static_cast<size_t>(parameters_.max_points)) {
    return fail("its number of points");
  }
  for (const SurfacePoint& point : points_) {
    if (!point.position.allFinite() || !(std::abs(point.normal.norm() - 1.0F) < 1e-3F)) {
      return fail("a point is not finite or its normal not of unit length");
    }
  }
  if (starts_.front() != 0 || starts_.back() != entries_.size()) return fail("its index");
  for (size_t i = 1; i < starts_.size(); ++i) {
    if (starts_[i] < starts_[i - 1]) return fail("its index is not ascending");
  }
  for (const Entry& entry : entries_) {
    if (entry.reference >= points_.size()) return fail("an entry names no point");
  }
  return {};
}

}  // namespace vantage
