#include "drivers/v4l2/video_node.h"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include "tests/drivers/v4l2/fake_video_folders.h"

namespace vantage {
namespace {

TEST(ListVideoNodes, TellsWhatSysfsAndUdevTell) {
  FakeVideoFolders folders;
  folders.AddUsb("1-2", "SN 123\xff");
  folders.AddNode("video10", "Intel(R) RealSense(TM)", "1-2", 2);
  folders.AddNode("video2", "vivid");
  folders.AddLink("by-id", "usb-Intel_RealSense-video-index0", "video10");
  folders.AddLink("by-path", "pci-0000:00:14.0-usb-0:2:1.0-video-index0", "video10");
  const std::vector<VideoNode> nodes = ListVideoNodes(folders.roots());
  ASSERT_EQ(nodes.size(), 2U);
  EXPECT_EQ(nodes[0].path, folders.dev("video2")) << "in the order of numbers";
  EXPECT_EQ(nodes[0].name, "vivid");
  EXPECT_EQ(nodes[0].serial, "");
  EXPECT_EQ(nodes[0].interface, "");
  EXPECT_EQ(nodes[1].path, folders.dev("video10"));
  EXPECT_EQ(nodes[1].name, "Intel(R) RealSense(TM)");
  EXPECT_EQ(nodes[1].serial, "SN123");
  EXPECT_EQ(nodes[1].interface, "1-2:1.0");
  EXPECT_EQ(nodes[1].role, "1.0/2");
  EXPECT_EQ(nodes[1].ids, std::vector<std::string>{"usb-Intel_RealSense-video-index0"});
  EXPECT_EQ(nodes[1].link_paths,
            (std::vector<std::string>{
                folders.dev("v4l/by-id/usb-Intel_RealSense-video-index0"),
                folders.dev("v4l/by-path/pci-0000:00:14.0-usb-0:2:1.0-video-index0")}));
}

TEST(ListVideoNodes, NodesOfADeviceShareItsSerialAndDevicesDoNot) {
  FakeVideoFolders folders;
  folders.AddUsb("1-1", "A");
  folders.AddUsb("1-2", "B");
  folders.AddUsb("1-3", "0001");
  folders.AddUsb("1-4", "0001");
  folders.AddNode("video0", "a", "1-1");
  folders.AddNode("video1", "a", "1-1");
  folders.AddNode("video2", "b", "1-2");
  folders.AddNode("video3", "c", "1-3");
  folders.AddNode("video4", "c", "1-4");
  std::string serials;
  for (const VideoNode& node : ListVideoNodes(folders.roots())) serials += node.serial + ",";
  EXPECT_EQ(serials, "A,A,B,,,");
}

TEST(ListVideoNodes, PassesOverOtherFilesAndMissingFolders) {
  FakeVideoFolders folders;
  for (const char* name : {"video", "videoX", "video1x", "vbi0", "video-1", "video99999999999"}) {
    folders.AddNode(name, "?");
  }
  std::filesystem::create_directories(folders.dev("v4l/by-id/no-link"));
  EXPECT_TRUE(ListVideoNodes(folders.roots()).empty());
  EXPECT_TRUE(ListVideoNodes({"/no/such/folder", "/no/such/folder"}).empty());
}

VideoCapability With(uint32_t capabilities) {
  VideoCapability capability;
  capability.card = "Card";
  capability.capabilities = capabilities;
  return capability;
}

TEST(CheckCapture, TakesWhatStreamsImages) {
  EXPECT_TRUE(CheckCapture(With(V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING), "x").ok());
  EXPECT_TRUE(CheckCapture(With(V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING), "x").ok());
  EXPECT_EQ(With(V4L2_CAP_VIDEO_CAPTURE).buffer_type(), uint32_t{V4L2_BUF_TYPE_VIDEO_CAPTURE});
  EXPECT_EQ(With(V4L2_CAP_VIDEO_CAPTURE_MPLANE).buffer_type(),
            uint32_t{V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE});
}

TEST(CheckCapture, SaysWhatElseANodeDoes) {
  const Result<void> metadata =
      CheckCapture(With(V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING), "/dev/video1");
  ASSERT_FALSE(metadata.ok());
  EXPECT_EQ(metadata.error().message,
            "device /dev/video1 (Card) can't stream images but does: metadata capture, streaming; "
            "expected video capture and streaming, which another node of the same device may have");
  EXPECT_FALSE(CheckCapture(With(V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_READWRITE), "x").ok());
  EXPECT_FALSE(CheckCapture(With(V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING), "x").ok());
  EXPECT_EQ(With(0).Words(), "nothing that is known here");
}

}  // namespace
}  // namespace vantage
