#include "drivers/openni2/usb_permission.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace vantage {
namespace {

constexpr uid_t kNobody = 65534;

TEST(UsbPermission, TellsTheGroupWhereThisUserMayNotOpenTheDevice) {
  std::string folder = (std::filesystem::temp_directory_path() / "vantage_usb_XXXXXX").string();
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  const std::filesystem::path usb = folder;
  ASSERT_EQ(chmod(folder.c_str(), 0755), 0);
  std::filesystem::create_directory(usb / "001");
  const std::filesystem::path node = usb / "001/005";
  std::ofstream(node) << "";
  EXPECT_EQ(UsbPermissionHint("1d27/0601@1/5", usb), "");
  ASSERT_EQ(chmod(node.c_str(), 0440), 0);
  const uid_t user = geteuid();
  ASSERT_TRUE(user != 0 || seteuid(kNobody) == 0);  // Root may do anything.
  const std::string hint = UsbPermissionHint("1d27/0601@1/5", usb);
  ASSERT_TRUE(user != 0 || seteuid(user) == 0);
  EXPECT_NE(hint.find("may not write to " + node.string() + ", which belongs to the group "),
            std::string::npos)
      << hint;
  std::filesystem::remove_all(usb);
}

TEST(UsbPermission, OtherUrisHaveNone) {
  for (const char* uri : {"vantage-sim://TEST",
                          "",
                          "@",
                          "1d27/0601@",
                          "1d27/0601@999999999999/5",
                          "1d27/0601@1",
                          "file@1/x",
                          "1d27/0601@250/250"}) {
    EXPECT_EQ(UsbPermissionHint(uri), "") << uri;
  }
}

}  // namespace
}  // namespace vantage
