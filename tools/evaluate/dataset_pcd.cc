#include "tools/evaluate/dataset_pcd.h"

#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <locale>
#include <map>
#include <sstream>
#include <string_view>

#include "common/format.h"
#include "perception/model/file_bytes.h"

namespace vantage {
namespace {

static_assert(std::endian::native == std::endian::little, "PCD files are little-endian");

constexpr size_t kLargestFile = size_t{256} << 20U;  // bytes
constexpr size_t kMostPoints = size_t{1} << 24U;
constexpr size_t kLargestSide = 16384;
constexpr size_t kLargestHeader = 4096;  // bytes
constexpr size_t kMostFields = 32;

struct Header {
  std::vector<size_t> field_bytes;  // Of one point.
  std::array<size_t, 3> xyz{};      // Indices of the fields.
  size_t width = 0;
  size_t height = 0;
  bool is_compressed = false;
  size_t data = 0;  // Where it begins.

  [[nodiscard]] size_t num_points() const { return width * height; }
  [[nodiscard]] size_t point_bytes() const {
    size_t sum = 0;
    for (const size_t bytes : field_bytes) sum += bytes;
    return sum;
  }
  [[nodiscard]] size_t Offset(size_t field) const {
    size_t sum = 0;
    for (size_t i = 0; i < field; ++i) sum += field_bytes[i];
    return sum;
  }
};

Error Damaged(const std::filesystem::path& file, const std::string& why) {
  return Error{ErrorCode::kCorrupt,
               Format("%s is no sound PCD file: %s", file.c_str(), why.c_str())};
}

using HeaderLines = std::map<std::string, std::vector<std::string>>;

// Words after the first of each line, up to and with DATA. Without DATA where there is none.
HeaderLines SplitHeader(std::string_view bytes, size_t* end) {
  HeaderLines lines;
  for (size_t at = 0; at < std::min(bytes.size(), kLargestHeader);) {
    const size_t stop = bytes.find('\n', at);
    if (stop == std::string_view::npos) break;
    std::istringstream words{std::string(bytes.substr(at, stop - at))};
    words.imbue(std::locale::classic());
    at = stop + 1;
    std::string key;
    if (!(words >> key) || key.front() == '#') continue;
    for (std::string word; words >> word;) lines[key].push_back(word);
    *end = at;
    if (key == "DATA") break;
  }
  return lines;
}

std::optional<size_t> NumberOf(const HeaderLines& lines, const char* key, size_t index = 0) {
  const auto found = lines.find(key);
  if (found == lines.end() || index >= found->second.size()) return std::nullopt;
  std::istringstream text(found->second[index]);
  text.imbue(std::locale::classic());
  size_t number = 0;
  if (found->second[index].front() == '-' || !(text >> number) || !text.eof()) return std::nullopt;
  return number;
}

Result<Header> ReadHeader(const std::filesystem::path& file, std::string_view bytes) {
  Header header;
  HeaderLines lines = SplitHeader(bytes, &header.data);
  if (lines["DATA"].size() != 1) return Damaged(file, "it has no line \"DATA\"");
  const std::string& data = lines["DATA"].front();
  header.is_compressed = data == "binary_compressed";
  if (!header.is_compressed && data != "binary") {
    return Damaged(file, Format("DATA %.40s, expected binary or binary_compressed", data.c_str()));
  }
  const std::vector<std::string>& fields = lines["FIELDS"];
  if (fields.empty() || fields.size() > kMostFields) {
    return Damaged(file, Format("%zu fields, expected 3 to %zu", fields.size(), kMostFields));
  }
  std::array<bool, 3> has{};
  for (size_t i = 0; i < fields.size(); ++i) {
    const std::optional<size_t> size = NumberOf(lines, "SIZE", i);
    const std::optional<size_t> count =
        lines["COUNT"].empty() ? std::optional<size_t>(1) : NumberOf(lines, "COUNT", i);
    if (!size || !count || *size < 1 || *size > 8 || *count > 4096) {
      return Damaged(file, Format("field %zu has no SIZE of 1 to 8 or COUNT up to 4096", i + 1));
    }
    header.field_bytes.push_back(*size * *count);
    constexpr std::array<const char*, 3> kNames = {"x", "y", "z"};
    for (size_t axis = 0; axis < 3; ++axis) {
      if (fields[i] != kNames[axis]) continue;
      header.xyz[axis] = i;
      has[axis] = *size == 4 && *count == 1 && i < lines["TYPE"].size() && lines["TYPE"][i] == "F";
    }
  }
  if (!has[0] || !has[1] || !has[2]) {
    return Damaged(file, "it has no fields x, y and z of 4-byte floats");
  }
  const std::optional<size_t> width = NumberOf(lines, "WIDTH");
  const std::optional<size_t> height = NumberOf(lines, "HEIGHT");
  if (!width || !height || *width < 1 || *height < 1 || *width > kMostPoints ||
      *height > kLargestSide || *width * *height > kMostPoints) {
    return Damaged(file, Format("it has no WIDTH and HEIGHT of 1 to %zu points", kMostPoints));
  }
  if (NumberOf(lines, "POINTS") != *width * *height) {
    return Damaged(file, Format("POINTS is not WIDTH x HEIGHT = %zu x %zu", *width, *height));
  }
  header.width = *width;
  header.height = *height;
  return header;
}

// The points' bytes; of compressed files each field's are together.
Result<std::string> ReadBody(const std::filesystem::path& file,
                             const Header& header,
                             std::string_view body) {
  const size_t expected = header.num_points() * header.point_bytes();
  if (!header.is_compressed) {
    if (body.size() < expected) {
      return Damaged(file, Format("%zu bytes of points, expected %zu", body.size(), expected));
    }
    return std::string(body.substr(0, expected));
  }
  std::array<uint32_t, 2> sizes{};
  if (body.size() < sizeof sizes) return Damaged(file, "it ends before its points");
  std::memcpy(sizes.data(), body.data(), sizeof sizes);
  body.remove_prefix(sizeof sizes);
  if (sizes[1] != expected) {
    return Damaged(file, Format("%u bytes of points, expected %zu", sizes[1], expected));
  }
  if (body.size() < sizes[0]) {
    return Damaged(file, Format("%zu compressed bytes, expected %u", body.size(), sizes[0]));
  }
  // One reference of 3 bytes gives 264 at most; what the file can't hold is not allocated.
  constexpr size_t kMostPerByte = 264;
  std::optional<std::string> points;
  if (expected / kMostPerByte <= sizes[0]) {
    points = DecompressLzf(
        {reinterpret_cast<const uint8_t*>(body.data()), static_cast<size_t>(sizes[0])}, expected);
  }
  if (!points) return Damaged(file, "its points can't be decompressed");
  return *std::move(points);
}

}  // namespace

std::optional<std::string> DecompressLzf(std::span<const uint8_t> bytes, size_t size) {
  std::string out;
  out.reserve(size);
  for (size_t at = 0; at < bytes.size();) {
    const size_t control = bytes[at++];
    if (control < 32) {  // So many literals, and one more.
      const size_t count = control + 1;
      if (count > bytes.size() - at || count > size - out.size()) return std::nullopt;
      out.append(reinterpret_cast<const char*>(&bytes[at]), count);
      at += count;
      continue;
    }
    size_t length = control >> 5U;
    if (length == 7) {
      if (at == bytes.size()) return std::nullopt;
      length += bytes[at++];
    }
    if (at == bytes.size()) return std::nullopt;
    const size_t back = ((control & 31U) << 8U) + bytes[at++] + 1;
    length += 2;
    if (back > out.size() || length > size - out.size()) return std::nullopt;
    // Byte by byte: a reference may reach into what it writes.
    for (size_t i = 0; i < length; ++i) out.push_back(out[out.size() - back]);
  }
  if (out.size() != size) return std::nullopt;
  return out;
}

Result<PointCloud> ReadPcd(const std::filesystem::path& file) {
  const Result<std::string> bytes = ReadFileBytes(file, kLargestFile);
  if (!bytes) return bytes.error();
  const Result<Header> header = ReadHeader(file, *bytes);
  if (!header) return header.error();
  const Result<std::string> body =
      ReadBody(file, *header, std::string_view(*bytes).substr(header->data));
  if (!body) return body.error();
  PointCloud cloud;
  cloud.width = static_cast<int>(header->width);
  cloud.height = static_cast<int>(header->height);
  cloud.points.resize(header->num_points());
  for (size_t axis = 0; axis < 3; ++axis) {
    const size_t offset = header->Offset(header->xyz[axis]);
    const size_t start = header->is_compressed ? offset * header->num_points() : offset;
    const size_t stride = header->is_compressed ? sizeof(float) : header->point_bytes();
    for (size_t i = 0; i < cloud.points.size(); ++i) {
      std::memcpy(&cloud.points[i][static_cast<Eigen::Index>(axis)],
                  body->data() + start + i * stride,
                  sizeof(float));
    }
  }
  return cloud;
}

}  // namespace vantage
