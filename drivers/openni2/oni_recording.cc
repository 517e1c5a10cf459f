#include "drivers/openni2/oni_recording.h"

#include <sys/resource.h>
#include <sys/types.h>

#include <chrono>
#include <cstdlib>
#include <set>
#include <thread>
#include <utility>

#include "common/format.h"

namespace vantage {
namespace {

constexpr int kLowPriority = 10;    // nice
constexpr int kCheckInterval = 15;  // images between looks at the disk

int64_t FreeBytes(const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(file.parent_path(), error);
  return error ? INT64_MAX : static_cast<int64_t>(space.available);
}

int64_t FileSize(const std::filesystem::path& file) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  return error ? -1 : static_cast<int64_t>(size);
}

// Of this process.
std::set<pid_t> Threads() {
  std::set<pid_t> threads;
  std::error_code error;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task", error)) {
    threads.insert(std::atoi(task.path().filename().c_str()));
  }
  return threads;
}

// Of the thread that came since, which is the recorder's. (One made for the purpose could pass its
// own on; but OpenNI2 crashes once a thread that ever called it has ended and a new one calls it.)
void LowerPriority(const std::set<pid_t>& before) {
  std::set<pid_t> after = Threads();
  std::erase_if(after, [&before](pid_t thread) { return before.contains(thread); });
  if (after.size() != 1) return;
  setpriority(PRIO_PROCESS, static_cast<id_t>(*after.begin()), kLowPriority);
}

}  // namespace

Result<void> RecordTarget::Validate() const {
  const auto reject = [this](ErrorCode code, const char* what) {
    return Error{code, Format("record_oni: %s %s", file.c_str(), what)};
  };
  std::error_code error;
  if (file.extension() != ".oni") {
    return reject(ErrorCode::kInvalidArgument, "has no ending .oni, expected one");
  }
  if (!std::filesystem::is_directory(file.parent_path(), error)) {
    return reject(ErrorCode::kNotFound, "lies in a folder that is not there, expected one that is");
  }
  if (std::filesystem::exists(file, error)) {
    return reject(ErrorCode::kInvalidArgument,
                  "exists and is not overwritten, expected a new file");
  }
  return {};
}

std::filesystem::path RecordTarget::NextFile() {
  std::error_code error;
  while (true) {
    ++num_files;
    std::filesystem::path next = file;
    if (num_files > 1) {
      next.replace_filename(Format("%s-%d.oni", file.stem().c_str(), num_files));
    }
    if (!std::filesystem::exists(next, error)) return next;
  }
}

Result<std::unique_ptr<OniRecording>> OniRecording::Open(const RecordTarget& target,
                                                         const std::filesystem::path& file,
                                                         openni::VideoStream& depth,
                                                         openni::VideoStream& color) {
  std::unique_ptr<OniRecording> recording(new OniRecording(file, target.min_free_bytes));
  if (std::string trouble = recording->Trouble(); !trouble.empty()) {
    return Error{ErrorCode::kIo, std::move(trouble)};
  }
  const std::set<pid_t> threads = Threads();
  const openni::Status created = recording->recorder_.create(file.c_str());
  LowerPriority(threads);
  if (created != openni::STATUS_OK || recording->recorder_.attach(depth) != openni::STATUS_OK ||
      (color.isValid() && recording->recorder_.attach(color) != openni::STATUS_OK)) {
    return Error{ErrorCode::kIo,
                 Format("recording %s can't be written; expected a folder that this user may "
                        "write to",
                        file.c_str())};
  }
  return recording;
}

OniRecording::~OniRecording() {
  recorder_.stop();
  recorder_.destroy();
  if (has_begun_) return;
  std::error_code error;
  std::filesystem::remove(file_, error);
}

bool OniRecording::Begin() {
  // The recorder has written what it knows of the streams when they were attached, and notes in the
  // file that it begins.
  const int64_t size = FileSize(file_);
  has_begun_ = true;
  if (recorder_.start() != openni::STATUS_OK) return false;
  for (int i = 0; i < 50; ++i) {
    if (FileSize(file_) > size) return true;
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  return false;
}

std::string OniRecording::Trouble() {
  if (num_images_++ % kCheckInterval != 0) return {};
  const int64_t free = FreeBytes(file_);
  if (free >= min_free_bytes_) return {};
  return Format("recording to %s has ended: %lld MB are free on its disk, expected %lld",
                file_.c_str(),
                static_cast<long long>(free >> 20),
                static_cast<long long>(min_free_bytes_ >> 20));
}

}  // namespace vantage
