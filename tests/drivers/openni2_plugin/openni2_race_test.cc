// Several devices and several programs, each of which wants one by its serial.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <string>

#include "drivers/openni2/device_lock.h"
#include "tests/drivers/openni2_plugin/openni2_fixture.h"

namespace vantage {
namespace {

/// A program that takes a device when it is told to.
class Racer {
 public:
  explicit Racer(const std::string& serial) {
    std::array<int, 2> in{};
    std::array<int, 2> out{};
    EXPECT_EQ(pipe2(in.data(), O_CLOEXEC), 0);
    EXPECT_EQ(pipe2(out.data(), O_CLOEXEC), 0);
    process_ = fork();
    if (process_ == 0) {
      dup2(in[0], STDIN_FILENO);
      dup2(out[1], STDOUT_FILENO);
      execl(VANTAGE_RACER, VANTAGE_RACER, serial.c_str(), nullptr);
      _exit(127);
    }
    close(in[0]);
    close(out[1]);
    to_ = in[1];
    from_ = out[0];
  }
  ~Racer() {
    close(to_);
    close(from_);
    waitpid(process_, nullptr, 0);
  }
  Racer(const Racer&) = delete;
  Racer& operator=(const Racer&) = delete;

  void Go() const { EXPECT_EQ(write(to_, "g", 1), 1); }
  /// 'y' once its device streams.
  [[nodiscard]] char Answer() const {
    char byte = 0;
    EXPECT_EQ(read(from_, &byte, 1), 1);
    return byte;
  }

 private:
  pid_t process_ = -1;
  int to_ = -1;
  int from_ = -1;
};

TEST(Openni2Race, EachProgramAlwaysGetsTheDeviceOfItsSerial) {
  const std::string name = "RACE" + std::to_string(getpid());
  setenv("VANTAGE_TEST_SERIALS", (name + "A," + name + "B").c_str(), 1);
  {
    const Racer a(name + "A");
    const Racer b(name + "B");
    for (int round = 0; round < 20; ++round) {
      const Racer& first = round % 2 == 0 ? a : b;
      const Racer& second = round % 2 == 0 ? b : a;
      first.Go();
      second.Go();
      ASSERT_EQ(a.Answer(), 'y') << round;
      ASSERT_EQ(b.Answer(), 'y') << round;
      a.Go();
      b.Go();
    }
  }
  unsetenv("VANTAGE_TEST_SERIALS");
}

TEST_F(Openni2Plugin, ADeviceOfAnotherProgramIsAskedAgain) {
  const std::string name = "HELD" + std::to_string(getpid());
  setenv("VANTAGE_TEST_SERIALS", name.c_str(), 1);
  abilities_.exclusive = true;
  auto holder = std::make_unique<Racer>(name);
  holder->Go();
  ASSERT_EQ(holder->Answer(), 'y');
  Create("serial:" + name);
  ASSERT_TRUE(GrabUntil([this] {
    return camera_->status().message.find("is another program using it") != std::string::npos;
  })) << camera_->status().message;
  EXPECT_EQ(camera_->status().state, CameraState::kSearching);
  EXPECT_TRUE(frames_.empty());
  holder.reset();
  EXPECT_TRUE(GrabFrames(1)) << camera_->status().message;
  unsetenv("VANTAGE_TEST_SERIALS");
}

TEST(DeviceLock, OneAtATimeForEachDevice) {
  const std::string uri = "test://" + std::to_string(getpid());
  constexpr std::chrono::milliseconds kShort{20};
  Result<std::unique_ptr<DeviceLock>> first = DeviceLock::Acquire(uri, kShort);
  ASSERT_TRUE(first.ok());
  EXPECT_TRUE(DeviceLock::Acquire(uri + "/other", kShort).ok());
  const Result<std::unique_ptr<DeviceLock>> second = DeviceLock::Acquire(uri, kShort);
  ASSERT_FALSE(second.ok());
  EXPECT_NE(second.error().message.find(uri), std::string::npos) << second.error().message;
  first.value().reset();
  EXPECT_TRUE(DeviceLock::Acquire(uri, kShort).ok());
}

}  // namespace
}  // namespace vantage
