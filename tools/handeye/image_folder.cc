#include "tools/handeye/image_folder.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "common/format.h"
#include "perception/model/file_bytes.h"
#include "tools/handeye/csv_table.h"
#include "tools/handeye/pose_file.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostImages = 10'000;
constexpr size_t kLargestPose = 64U << 10U;  // bytes

Error Wrong(std::string message) { return {ErrorCode::kInvalidArgument, std::move(message)}; }

// What stands before and after the number.
struct Pattern {
  std::string before;
  std::string after;

  static Result<Pattern> Parse(const std::string& text) {
    const size_t at = text.find("%d");
    if (at == std::string::npos || text.find('/') != std::string::npos) {
      return Wrong(
          Format("pattern '%.100s', expected a file's name with %%d for its number, such as "
                 "image-%%d.png",
                 text.c_str()));
    }
    return Pattern{text.substr(0, at), text.substr(at + 2)};
  }
  [[nodiscard]] std::optional<int64_t> NumberIn(std::string_view name) const {
    if (name.size() <= before.size() + after.size() || !name.starts_with(before) ||
        !name.ends_with(after)) {
      return std::nullopt;
    }
    name = name.substr(before.size(), name.size() - before.size() - after.size());
    int64_t number = 0;
    const auto [stop, error] = std::from_chars(name.data(), name.data() + name.size(), number);
    if (error != std::errc() || stop != name.data() + name.size()) return std::nullopt;
    return number;
  }
};

// Files of a folder by their number.
Result<std::map<int64_t, fs::path>> Numbered(const fs::path& folder, const std::string& text) {
  const Result<Pattern> pattern = Pattern::Parse(text);
  if (!pattern) return pattern.error();
  std::map<int64_t, fs::path> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const auto number = pattern->NumberIn(entry.path().filename().string());
    if (number) files.emplace(*number, entry.path());
    if (files.size() > kMostImages) {
      return Wrong(
          Format("%s has more than %zu files %s", folder.c_str(), kMostImages, text.c_str()));
    }
  }
  if (error)
    return Error{ErrorCode::kIo, Format("%s: %s", folder.c_str(), error.message().c_str())};
  if (files.empty()) {
    return Error{ErrorCode::kNotFound,
                 Format("%s has no file %s, expected at least 3", folder.c_str(), text.c_str())};
  }
  return files;
}

// Every number of a text; those before "data:" are of the YAML's own.
std::vector<double> NumbersIn(std::string_view text) {
  if (const size_t data = text.find("data:"); data != std::string_view::npos) {
    text.remove_prefix(data + 5);
  }
  std::vector<double> numbers;
  size_t at = 0;
  while ((at = text.find_first_of("+-.0123456789naif", at)) != std::string_view::npos) {
    const size_t end = std::min(text.find_first_of(" \t\r\n,;[]", at), text.size());
    double value = 0.0;
    const std::string_view word = text.substr(at, end - at);
    const char* begin = word.data() + (word.front() == '+' ? 1 : 0);
    const auto [stop, error] = std::from_chars(begin, word.data() + word.size(), value);
    if (error == std::errc() && stop == word.data() + word.size()) numbers.push_back(value);
    at = end;
  }
  return numbers;
}

Result<RawPose> ReadPoseText(const fs::path& file) {
  const Result<std::string> text = ReadFileBytes(file, kLargestPose);
  if (!text) return text.error();
  const std::vector<double> numbers = NumbersIn(*text);
  const bool finite =
      std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); });
  if (!finite || (numbers.size() != 6 && numbers.size() != 16)) {
    return Error{
        ErrorCode::kCorrupt,
        Format("%s holds %zu numbers%s, expected the 6 of a translation (m) and a rotation "
               "vector (rad), or the 16 of a matrix",
               file.c_str(),
               numbers.size(),
               finite ? "" : ", some not finite")};
  }
  if (numbers.size() == 6) {
    return RawPose{.translation = {numbers[0], numbers[1], numbers[2]},
                   .kind = RawPose::Rotation::kRotationVector,
                   .rotation = {numbers[3], numbers[4], numbers[5]}};
  }
  Result<RawPose> pose = RawFromMatrix(numbers);
  if (pose) return pose;
  return Error{pose.error().code, Format("%s: %s", file.c_str(), pose.error().message.c_str())};
}

Result<std::vector<FolderImage>> ByPatterns(const ImageFolderLayout& layout) {
  const auto images = Numbered(layout.folder, layout.image_pattern);
  if (!images) return images.error();
  const auto poses = Numbered(layout.folder, layout.pose_pattern);
  if (!poses) return poses.error();
  std::vector<FolderImage> views;
  for (const auto& [number, image] : *images) {
    const auto pose_file = poses->find(number);
    if (pose_file == poses->end()) {
      return Error{ErrorCode::kNotFound,
                   Format("image %s has no pose, expected %s with the number %jd",
                          image.c_str(),
                          layout.pose_pattern.c_str(),
                          intmax_t{number})};
    }
    const Result<RawPose> hand = ReadPoseText(pose_file->second);
    if (!hand) return hand.error();
    views.push_back({image, 0, *hand});
  }
  return views;
}

Result<std::vector<FolderImage>> ByTable(const fs::path& folder) {
  const fs::path file = folder / "poses.csv";
  const Result<CsvTable> table = CsvTable::Read(file);
  if (!table) {
    return Error{
        table.error().code,
        Format("%s (or say --image-pattern and --pose-pattern)", table.error().message.c_str())};
  }
  const std::optional<size_t> image = table->Column("image");
  if (!image) {
    return Error{ErrorCode::kCorrupt, Format("%s lacks the column 'image'", file.c_str())};
  }
  const Result<PoseColumns> hand = PoseColumns::Find(*table, "hand");
  if (!hand) {
    return Error{hand.error().code, Format("%s %s", file.c_str(), hand.error().message.c_str())};
  }
  std::vector<size_t> used = hand->used();
  used.push_back(*image);
  if (Result<void> known = CheckColumns(*table, file.string(), used); !known) return known.error();
  if (table->num_rows() > kMostImages) {
    return Wrong(Format(
        "%s has %zu rows, expected at most %zu", file.c_str(), table->num_rows(), kMostImages));
  }
  std::vector<FolderImage> views;
  for (size_t row = 0; row < table->num_rows(); ++row) {
    const Result<RawPose> pose = hand->Read(*table, row);
    if (!pose) return pose.error();
    const Result<int64_t> utime = ReadUtime(*table, row);
    if (!utime) return utime.error();
    views.push_back({folder / table->Text(row, *image), *utime, *pose});
  }
  return views;
}

}  // namespace

Result<std::vector<FolderImage>> ReadImageFolder(const ImageFolderLayout& layout) {
  std::error_code error;
  if (!fs::is_directory(layout.folder, error)) {
    return Error{ErrorCode::kNotFound,
                 Format("%s is no folder, expected one with images and poses of the robot",
                        layout.folder.c_str())};
  }
  if (layout.image_pattern.empty() != layout.pose_pattern.empty()) {
    return Wrong("expected --image-pattern and --pose-pattern together");
  }
  return layout.image_pattern.empty() ? ByTable(layout.folder) : ByPatterns(layout);
}

}  // namespace vantage
