#include "tools/viewer/video_writer.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

#include "common/format.h"

namespace vantage {
namespace {

// What ffmpeg is told about the outgoing video; empty: no kind that we make.
std::vector<std::string> EncoderOptions(const std::string& extension) {
  if (extension == ".mp4") {
    return {"-c:v",
            "libx264",
            "-preset",
            "veryfast",
            "-crf",
            "20",
            "-pix_fmt",
            "yuv420p",
            "-movflags",
            "+faststart",
            "-f",
            "mp4"};
  }
  if (extension == ".webm") {
    return {"-c:v",
            "libvpx-vp9",
            "-deadline",
            "realtime",
            "-cpu-used",
            "6",
            "-crf",
            "32",
            "-b:v",
            "0",
            "-pix_fmt",
            "yuv420p",
            "-f",
            "webm"};
  }
  if (extension == ".gif") {
    return {"-vf",
            "split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse=dither=none",
            "-f",
            "gif"};
  }
  return {};
}

bool IsInstalled(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::string rest = path == nullptr ? "/usr/bin:/bin" : path;
  while (!rest.empty()) {
    const size_t colon = rest.find(':');
    const std::string folder = rest.substr(0, colon);
    if (access((folder + '/' + program).c_str(), X_OK) == 0) return true;
    rest = colon == std::string::npos ? "" : rest.substr(colon + 1);
  }
  return false;
}

[[noreturn]] void BecomeEncoder(int frames,
                                const std::string& words,
                                const std::vector<std::string>& arguments) {
  setpgid(0, 0);  // Ctrl-C is the viewer's.
  sigset_t none;  // What the viewer holds back is not held back from it.
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  dup2(frames, STDIN_FILENO);
  const int to = open(words.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  dup2(to, STDERR_FILENO);
  dup2(to, STDOUT_FILENO);
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execvp("ffmpeg", argv.data());
  _exit(127);
}

}  // namespace

std::filesystem::path VideoWriter::Temporary() const {
  return file_.parent_path() / Format(".%s.%d", file_.filename().c_str(), getpid());
}
std::filesystem::path VideoWriter::Words() const { return Temporary().string() + ".log"; }

Result<std::unique_ptr<VideoWriter>> VideoWriter::Create(const std::filesystem::path& file,
                                                         int width,
                                                         int height,
                                                         double fps) {
  const std::vector<std::string> encoder = EncoderOptions(file.extension().string());
  if (encoder.empty()) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("video %s is of no known kind, expected .mp4, .webm or .gif", file.c_str())};
  }
  if (!IsInstalled("ffmpeg")) {
    return Error{ErrorCode::kNotFound,
                 "ffmpeg is not installed, which makes the video; apt-get install ffmpeg"};
  }
  std::unique_ptr<VideoWriter> writer(new VideoWriter(file, width, height));
  std::vector<std::string> arguments = {"ffmpeg",
                                        "-hide_banner",
                                        "-loglevel",
                                        "error",
                                        "-y",
                                        "-f",
                                        "rawvideo",
                                        "-pix_fmt",
                                        "rgb24",
                                        "-s",
                                        Format("%dx%d", width, height),
                                        "-r",
                                        Format("%g", fps),
                                        "-i",
                                        "-"};
  arguments.insert(arguments.end(), encoder.begin(), encoder.end());
  arguments.push_back(writer->Temporary());
  const std::string words = writer->Words();
  if (!std::ofstream(words)) {
    return Error{ErrorCode::kIo,
                 Format("video %s can't be written: no such folder, or not allowed", file.c_str())};
  }
  int ends[2];
  if (pipe2(static_cast<int*>(ends), O_CLOEXEC) != 0) {
    return Error{ErrorCode::kIo, Format("a pipe can't be made: %s", std::strerror(errno))};
  }
  std::signal(SIGPIPE, SIG_IGN);  // An encoder that ends is told by the failing write.
  writer->process_ = fork();
  if (writer->process_ == 0) BecomeEncoder(ends[0], words, arguments);
  close(ends[0]);
  writer->pipe_ = fdopen(ends[1], "wb");
  return writer;
}

VideoWriter::~VideoWriter() {
  if (pipe_ != nullptr) std::fclose(pipe_);
  if (process_ > 0) {
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
  }
  std::error_code ignored;
  std::filesystem::remove(Temporary(), ignored);
  std::filesystem::remove(Words(), ignored);
}

Error VideoWriter::Failure() const {
  std::ifstream words(Words());
  std::string line;
  std::getline(words, line);
  if (line.empty()) line = "it ended without a word";
  return {ErrorCode::kIo, Format("video %s: ffmpeg failed: %s", file_.c_str(), line.c_str())};
}

Result<void> VideoWriter::Write(const RgbImage& frame) {
  if (frame.width != width_ || frame.height != height_) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format(
            "frame of %d x %d px, expected %d x %d", frame.width, frame.height, width_, height_)};
  }
  if (std::fwrite(frame.rgb.data(), 1, frame.rgb.size(), pipe_) != frame.rgb.size()) {
    return Failure();
  }
  return {};
}

Result<void> VideoWriter::Close() {
  const bool flushed = std::fclose(pipe_) == 0;
  pipe_ = nullptr;
  int status = 0;
  waitpid(process_, &status, 0);
  process_ = -1;
  if (!flushed || !WIFEXITED(status) || WEXITSTATUS(status) != 0) return Failure();
  std::error_code error;
  std::filesystem::rename(Temporary(), file_, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 Format("video %s can't be written: %s", file_.c_str(), error.message().c_str())};
  }
  return {};
}

}  // namespace vantage
