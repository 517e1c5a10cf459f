#include "drivers/v4l2/v4l2_ioctl.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>

#include "common/format.h"
#include "drivers/v4l2/video_node.h"

namespace vantage {
namespace {

std::string OpenError(const std::string& path) {
  const Result<FileDescriptor> fd = OpenVideoNode(path);
  return fd.ok() ? "" : fd.error().message;
}

TEST(OpenVideoNode, RefusesWhatIsNoVideoDevice) {
  const std::string file = testing::TempDir() + Format("v4l2_ioctl_test.%d", getpid());
  std::ofstream(file) << "no device";
  EXPECT_EQ(OpenError(file),
            "device " + file + " is no character device, expected one such as /dev/video0");
  std::filesystem::remove(file);
  EXPECT_EQ(OpenError("/dev/null"),
            "device /dev/null has the major number 1, expected 81 of a video device such as "
            "/dev/video0");
  EXPECT_EQ(
      OpenError(testing::TempDir()),
      "device " + testing::TempDir() + " is no character device, expected one such as /dev/video0");
  EXPECT_EQ(OpenError("/no/such/node"),
            "device /no/such/node can't be opened: No such file or directory");
  EXPECT_NE(OpenError(""), "");
}

TEST(ReadCapability, RefusesAFileThatIsNoV4l2Device) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const FileDescriptor reader(ends[0]);
  const FileDescriptor writer(ends[1]);
  const Result<VideoCapability> capability = ReadCapability(reader.get(), "/dev/x");
  ASSERT_FALSE(capability.ok());
  EXPECT_EQ(capability.error().message,
            "device /dev/x is no V4L2 device, expected one such as /dev/video0");
}

TEST(SystemError, SaysWhatMends) {
  EXPECT_EQ(SystemError("/dev/video0", "does not start to stream", EBUSY).message,
            "device /dev/video0 does not start to stream: Device or resource busy; another program "
            "streams from it: `fuser -v /dev/video*` tells which");
  EXPECT_EQ(SystemError("/dev/video0", "refuses YUYV", EINVAL).message,
            "device /dev/video0 refuses YUYV: Invalid argument");
}

TEST(FileDescriptor, ClosesOnce) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  FileDescriptor reader(ends[0]);
  {
    FileDescriptor writer(ends[1]);
    const FileDescriptor moved(std::move(writer));
    EXPECT_FALSE(writer.is_open());  // NOLINT(bugprone-use-after-move)
    EXPECT_EQ(moved.get(), ends[1]);
  }
  char byte = 0;
  EXPECT_EQ(read(reader.get(), &byte, 1), 0) << "the writing end is closed";
}

}  // namespace
}  // namespace vantage
