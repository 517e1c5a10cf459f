#include "nodes/fusion_state_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <utility>

#include "common/format.h"
#include "common/time_range.h"
#include "fusion/state_text.h"

namespace vantage {
namespace {

constexpr const char* kMagic = "vantage-fusion-state 2";
constexpr std::uintmax_t kLargestFile = 64U << 20U;  // bytes

// FNV-1a, 64 bits.
std::string Checksum(const std::string& text) {
  uint64_t hash = 14695981039346656037ULL;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return Format("%016llx", static_cast<unsigned long long>(hash));
}

std::string Header(const std::string& body) {
  return std::string(kMagic) + "\nchecksum " + Checksum(body) + "\n";
}

Error SystemError(const std::string& what, const std::filesystem::path& file) {
  return Error{ErrorCode::kIo,
               Format("%s %s: %s", what.c_str(), file.c_str(), std::strerror(errno))};
}

Result<void> WriteAll(int descriptor, const std::string& text, const std::filesystem::path& file) {
  size_t written = 0;
  while (written < text.size()) {
    const ssize_t count = write(descriptor, text.data() + written, text.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return SystemError("can't write the state file", file);
    written += static_cast<size_t>(count);
  }
  if (fsync(descriptor) != 0) return SystemError("can't write the state file", file);
  return {};
}

Error Damaged(const std::filesystem::path& file, const std::string& what) {
  return Error{
      ErrorCode::kCorrupt,
      Format("state file %s %s, expected what vantage-fusion wrote", file.c_str(), what.c_str())};
}

}  // namespace

Result<void> SaveFusionState(const FusionState& state, const std::filesystem::path& file) {
  const std::string body = Format("setup ") + FormatName(state.setup) +
                           Format("\nutime %lld\n", static_cast<long long>(state.utime)) +
                           FormatViewSequenceState(state.views) + FormatTrackerState(state.tracker);
  const std::filesystem::path temporary = file.string() + ".tmp";
  const int descriptor = open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor < 0) return SystemError("can't write the state file", temporary);
  Result<void> written = WriteAll(descriptor, Header(body) + body, temporary);
  close(descriptor);
  if (written.ok() && std::rename(temporary.c_str(), file.c_str()) != 0) {
    written = SystemError("can't rename the state file to", file);
  }
  if (!written) unlink(temporary.c_str());
  return written;
}

Result<std::optional<FusionState>> LoadFusionState(const std::filesystem::path& file,
                                                   const std::string& setup) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return std::optional<FusionState>();
  if (!std::filesystem::is_regular_file(file, error)) return Damaged(file, "is no file");
  if (std::filesystem::file_size(file, error) > kLargestFile) return Damaged(file, "is too large");
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream content;
  content << stream.rdbuf();
  if (!stream) return SystemError("can't read the state file", file);

  const std::string text = content.str();
  if (!text.starts_with(std::string(kMagic) + "\n")) {
    return Damaged(file, Format("does not begin with \"%s\"", kMagic));
  }
  const size_t header_size = Header("").size();
  if (text.size() < header_size) return Damaged(file, "is cut off");
  const std::string body = text.substr(header_size);
  if (text.substr(0, header_size) != Header(body)) {
    return Damaged(file, "does not have the checksum that it names");
  }

  FusionState state;
  StateReader reader(body);
  reader.Keyword("setup");
  state.setup = reader.Name();
  if (!reader.failed() && state.setup != setup) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("state file %s is of another set-up (%s), expected %s",
                        file.c_str(),
                        state.setup.c_str(),
                        setup.c_str())};
  }
  reader.Keyword("utime");
  state.utime = reader.Number<int64_t>(0, kLatestUtime);
  state.views = ReadViewSequenceState(reader);
  if (reader.failed()) return Damaged(file, "is damaged: " + reader.error());
  Result<TrackerState> tracker = ParseTrackerState(reader.Rest());
  if (!tracker) return Damaged(file, "is damaged: " + tracker.error().message);
  state.tracker = std::move(*tracker);
  return std::optional<FusionState>(std::move(state));
}

Result<void> PrepareStateFile(const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::path folder = file.parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error || access(folder.empty() ? "." : folder.c_str(), W_OK) != 0) {
    return Error{ErrorCode::kIo,
                 Format("folder of the state file %s can't be %s (%s), expected one to write into",
                        file.c_str(),
                        error ? "made" : "written",
                        error ? error.message().c_str() : std::strerror(errno))};
  }
  if (std::filesystem::exists(file, error) && !std::filesystem::is_regular_file(file, error)) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("state file %s is a folder or a device, expected the name of a file", file.c_str())};
  }
  return {};
}

Result<void> MoveAside(const std::filesystem::path& file) {
  const std::filesystem::path aside = file.string() + ".bad";
  if (std::rename(file.c_str(), aside.c_str()) != 0) {
    return SystemError("can't move aside the state file", file);
  }
  return {};
}

}  // namespace vantage
