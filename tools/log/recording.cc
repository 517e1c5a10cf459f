#include "tools/log/recording.h"

#include <array>
#include <ctime>
#include <system_error>

#include "bus/message_check.h"
#include "common/format.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHeaderChannel = "LOG_HEADER";
constexpr int kMostOfOneSecond = 1000;

// "2026-11-22T20-45-49Z": no colons, which other systems don't take in names.
std::string TimeName(int64_t utime) {
  const auto seconds = static_cast<std::time_t>(utime / 1'000'000);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H-%M-%SZ", &parts);
  return text.data();
}

fs::path PartPath(const fs::path& file, size_t number) {
  return file.parent_path() /
         (file.stem().string() + Format("-%03zu", number) + file.extension().string());
}

Result<void> CheckFolder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (fs::is_directory(folder, error)) return {};
  return Error{ErrorCode::kIo,
               Format("folder %s for recordings is none and can't be made", folder.c_str())};
}

}  // namespace

Result<std::unique_ptr<Recording>> Recording::Start(const RecordingOptions& options,
                                                    int64_t utime) {
  std::unique_ptr<Recording> recording(new Recording(options));
  if (!options.folder.empty()) {
    if (Result<void> there = CheckFolder(options.folder); !there) return there.error();
  }
  if (Result<void> begun = recording->Begin(utime); !begun) return begun.error();
  return recording;
}

Result<void> Recording::Write(int64_t utime,
                              const std::string& channel,
                              std::span<const std::byte> data) {
  if (IsFull(utime, data.size())) {
    if (Result<void> synced = file_->Sync(); !synced) return synced;
    if (Result<void> begun = Begin(utime); !begun) return begun;
  }
  return file_->Write(utime, channel, data);
}

Result<void> Recording::Poll() {
  if (Result<void> flushed = file_->Flush(); !flushed) return flushed;
  return CheckDisk(file_->path());
}

Result<void> Recording::Sync() { return file_->Sync(); }

std::vector<Recording::Part> Recording::Parts() const {
  std::vector<Part> parts = done_;
  parts.push_back({file_->path(), file_->num_events(), file_->num_bytes()});
  return parts;
}

fs::path Recording::NextPath(int64_t utime) const {
  if (options_.folder.empty()) {
    const bool is_split = options_.split_bytes > 0 || options_.split_us > 0;
    return is_split ? PartPath(options_.file, done_.size()) : options_.file;
  }
  const fs::path path = options_.folder / TimeName(utime);
  std::error_code error;
  for (int i = 2; i < kMostOfOneSecond; ++i) {
    fs::path numbered = path;
    numbered += i == 2 ? ".lcm" : Format("-%d.lcm", i - 1);
    if (!fs::exists(numbered, error)) return numbered;
  }
  return path.string() + ".lcm";
}

Result<void> Recording::Begin(int64_t utime) {
  if (file_ != nullptr) done_ = Parts();
  const fs::path path = NextPath(utime);
  std::error_code error;
  const bool is_first_of_several = done_.empty() && path != options_.file;
  if (options_.folder.empty() && is_first_of_several && !options_.overwrite &&
      fs::exists(PartPath(options_.file, 1), error)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("recording %s exists already, expected a new name or --force",
                        PartPath(options_.file, 1).c_str())};
  }
  if (Result<void> enough = CheckDisk(path); !enough) return enough;
  Result<std::unique_ptr<RecordingFile>> file = RecordingFile::Create(path, options_.overwrite);
  if (!file) return file.error();
  file_ = std::move(file).value();
  begin_utime_ = utime;
  return file_->Write(utime, kHeaderChannel, Encode(MakeLogHeader(options_.setup, utime)));
}

bool Recording::IsFull(int64_t utime, size_t more) const {
  if (file_->num_events() < 2) return false;
  return (options_.split_bytes > 0 &&
          file_->num_bytes() + static_cast<int64_t>(more) > options_.split_bytes) ||
         (options_.split_us > 0 && utime - begin_utime_ >= options_.split_us);
}

Result<void> Recording::CheckDisk(const fs::path& file) const {
  std::error_code error;
  const fs::space_info space = fs::space(fs::absolute(file).parent_path(), error);
  if (error) {
    return Error{
        ErrorCode::kIo,
        Format("recording %s can't be written: %s", file.c_str(), error.message().c_str())};
  }
  if (space.available >= static_cast<uintmax_t>(options_.min_free_bytes)) return {};
  return Error{ErrorCode::kUnavailable,
               Format("the disk of recording %s has %.3g MB left, expected %.3g MB (--min-free-mb)",
                      file.c_str(),
                      1e-6 * static_cast<double>(space.available),
                      1e-6 * static_cast<double>(options_.min_free_bytes))};
}

}  // namespace vantage
