#include "bus/process_name_lock.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>

#include "common/format.h"

namespace vantage {
namespace {

constexpr const char* kUrl = "udpm://239.255.76.67:7667";

class ProcessNameLockTest : public testing::Test {
 protected:
  ProcessNameLockTest() { setenv("XDG_RUNTIME_DIR", folder_.c_str(), 1); }
  ~ProcessNameLockTest() override {
    unsetenv("XDG_RUNTIME_DIR");
    std::filesystem::remove_all(folder_);
  }

  static std::filesystem::path MakeFolder() {
    std::string name = testing::TempDir() + "vantage-lock-XXXXXX";
    return mkdtemp(name.data());
  }

  std::filesystem::path folder_ = MakeFolder();
};

TEST_F(ProcessNameLockTest, RefusesASecondHolderUntilTheFirstLetsGo) {
  auto first = ProcessNameLock::Acquire("ppf", kUrl);
  ASSERT_TRUE(first.ok()) << first.error().message;
  EXPECT_FALSE(ProcessNameLock::Acquire("ppf", kUrl).ok());
  EXPECT_FALSE(ProcessNameLock::Acquire("ppf", std::string(kUrl) + "?ttl=0").ok());
  EXPECT_TRUE(ProcessNameLock::Acquire("shot", kUrl).ok());
  EXPECT_TRUE(ProcessNameLock::Acquire("ppf", "udpm://239.255.76.67:7668").ok());
  first->reset();
  EXPECT_TRUE(ProcessNameLock::Acquire("ppf", kUrl).ok());
}

TEST_F(ProcessNameLockTest, NamesAnotherProcessAndSurvivesItsKill) {
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    const auto lock = ProcessNameLock::Acquire("ppf", kUrl);
    const char answer = lock.ok() ? 'y' : 'n';
    if (write(ready[1], &answer, 1) != 1) _exit(1);
    while (true) pause();
  }
  char answer = 0;
  ASSERT_EQ(read(ready[0], &answer, 1), 1);
  EXPECT_EQ(answer, 'y');
  const auto refused = ProcessNameLock::Acquire("ppf", kUrl);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(ready[0]);
  close(ready[1]);
  ASSERT_FALSE(refused.ok());
  for (const std::string& part : {std::string("'ppf'"),
                                  std::string(kUrl),
                                  Format("kill %d,", child),
                                  std::string("--name OTHER")}) {
    EXPECT_NE(refused.error().message.find(part), std::string::npos) << refused.error().message;
  }
  EXPECT_TRUE(ProcessNameLock::Acquire("ppf", kUrl).ok());
}

TEST_F(ProcessNameLockTest, LeavesNothingBehind) {
  { const auto lock = ProcessNameLock::Acquire("ppf", kUrl); }
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "vantage"));
}

TEST_F(ProcessNameLockTest, RefusesAFolderThatOthersMayWrite) {
  ASSERT_TRUE(std::filesystem::create_directory(folder_ / "vantage"));
  ASSERT_EQ(chmod((folder_ / "vantage").c_str(), 0777), 0);
  const auto lock = ProcessNameLock::Acquire("ppf", kUrl);
  ASSERT_FALSE(lock.ok());
  EXPECT_NE(lock.error().message.find("0700"), std::string::npos);
}

TEST_F(ProcessNameLockTest, RefusesNamesThatAreNoFileNames) {
  for (const char* name : {"", "a/b", "../a", "a b"}) {
    EXPECT_FALSE(ProcessNameLock::Acquire(name, kUrl).ok()) << name;
  }
}

}  // namespace
}  // namespace vantage
