#include "bus/process_name_lock.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>
#include <string>

#include "common/format.h"
#include "tests/bus/live/private_network.h"

namespace vantage {
namespace {

constexpr const char* kUrl = "udpm://239.255.76.67:7667";

// Of this run alone, should the test not be in a network of its own.
std::string Name(const std::string& name) {
  static const std::string suffix = Format("-%d", getpid());
  return name + suffix;
}

// What `work` gives back in a child process; 255 when it died.
int InChild(const std::function<int()>& work) {
  const pid_t child = fork();
  if (child == 0) _exit(work());
  int status = 0;
  const bool ended = waitpid(child, &status, 0) == child && WIFEXITED(status);
  return ended ? WEXITSTATUS(status) : 255;
}

constexpr int kAcquired = 0;
constexpr int kHeld = 1;
constexpr int kFailed = 2;      // for another reason
constexpr int kNotAllowed = 3;  // by the system, to set the scene

int TryAcquire(const std::string& name) {
  const auto lock = ProcessNameLock::Acquire(name, kUrl);
  if (lock.ok()) return kAcquired;
  return lock.error().message.find("already") != std::string::npos ? kHeld : kFailed;
}

TEST(ProcessNameLock, RefusesASecondHolderUntilTheFirstLetsGo) {
  auto first = ProcessNameLock::Acquire(Name("ppf"), kUrl);
  ASSERT_TRUE(first.ok()) << first.error().message;
  EXPECT_FALSE(ProcessNameLock::Acquire(Name("ppf"), kUrl).ok());
  EXPECT_FALSE(ProcessNameLock::Acquire(Name("ppf"), std::string(kUrl) + "?ttl=0").ok());
  EXPECT_TRUE(ProcessNameLock::Acquire(Name("shot"), kUrl).ok());
  EXPECT_TRUE(ProcessNameLock::Acquire(Name("ppf"), "udpm://239.255.76.67:7668").ok());
  first->reset();
  EXPECT_TRUE(ProcessNameLock::Acquire(Name("ppf"), kUrl).ok());
}

TEST(ProcessNameLock, NamesAnotherProcessAndSurvivesItsKill) {
  const std::string name = Name("ppf");
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    const auto lock = ProcessNameLock::Acquire(name, kUrl);
    const char answer = lock.ok() ? 'y' : 'n';
    if (write(ready[1], &answer, 1) != 1) _exit(1);
    while (true) pause();
  }
  char answer = 0;
  ASSERT_EQ(read(ready[0], &answer, 1), 1);
  EXPECT_EQ(answer, 'y');
  const auto refused = ProcessNameLock::Acquire(name, kUrl);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(ready[0]);
  close(ready[1]);
  ASSERT_FALSE(refused.ok());
  for (const std::string& part : {"'" + name + "'",
                                  std::string(kUrl),
                                  Format("kill %d,", child),
                                  std::string("--name OTHER")}) {
    EXPECT_NE(refused.error().message.find(part), std::string::npos) << refused.error().message;
  }
  EXPECT_TRUE(ProcessNameLock::Acquire(name, kUrl).ok());
}

TEST(ProcessNameLock, ManyRefusalsDoNotHideTheHolder) {
  const auto lock = ProcessNameLock::Acquire(Name("ppf"), kUrl);
  ASSERT_TRUE(lock.ok());
  for (int i = 0; i < 10'000; ++i) {
    const auto refused = ProcessNameLock::Acquire(Name("ppf"), kUrl);
    ASSERT_FALSE(refused.ok());
    ASSERT_EQ(refused.error().code, ErrorCode::kUnavailable) << refused.error().message;
  }
}

// Their messages meet, so their names must differ.
TEST(ProcessNameLock, IsSeenByOtherUsersOfTheNetwork) {
  const std::string name = Name("ppf");
  const auto lock = ProcessNameLock::Acquire(name, kUrl);
  ASSERT_TRUE(lock.ok());
  const int outcome = InChild([&name] {
    // No user of the outside is known in there.
    return unshare(CLONE_NEWUSER) == 0 ? TryAcquire(name) : kNotAllowed;
  });
  if (outcome == kNotAllowed) GTEST_SKIP() << "needs the right to make a user namespace";
  EXPECT_EQ(outcome, kHeld);
}

// Whoever calls itself root in a network of its own, as under unshare -Urn.
TEST(ProcessNameLock, IsNotSeenInOtherNetworks) {
  VANTAGE_NEEDS_PRIVATE_NETWORK();
  const std::string name = Name("ppf");
  const auto lock = ProcessNameLock::Acquire(name, kUrl);
  ASSERT_TRUE(lock.ok());
  EXPECT_EQ(
      InChild([&name] { return unshare(CLONE_NEWNET) == 0 ? TryAcquire(name) : kNotAllowed; }),
      kAcquired);
  const int outcome = InChild([&name] {
    constexpr uid_t kSomebody = 12345;
    if (setuid(kSomebody) != 0) return kNotAllowed;
    prctl(PR_SET_DUMPABLE, 1);  // Else its own /proc/self/uid_map is closed to it.
    if (!EnterPrivateNetwork(false)) return kNotAllowed;
    return TryAcquire(name);
  });
  if (outcome == kNotAllowed) GTEST_SKIP() << "needs the right to become another user";
  EXPECT_EQ(outcome, kAcquired);
}

// A holder outside of the container has no process id in it: then there is nothing to kill.
TEST(ProcessNameLock, AHolderThatCannotBeKnownIsNotToBeKilled) {
  VANTAGE_NEEDS_PRIVATE_NETWORK();
  const std::string name = Name("ppf");
  const auto lock = ProcessNameLock::Acquire(name, kUrl);
  ASSERT_TRUE(lock.ok());
  const int outcome = InChild([&name] {
    if (unshare(CLONE_NEWPID) != 0) return kNotAllowed;
    return InChild([&name] {
      const auto refused = ProcessNameLock::Acquire(name, kUrl);
      if (refused.ok()) return kAcquired;
      const std::string& message = refused.error().message;
      const bool is_good = message.find("kill") == std::string::npos &&
                           message.find("pid") == std::string::npos &&
                           message.find("start this one with --name OTHER") != std::string::npos;
      return is_good ? kHeld : kFailed;
    });
  });
  if (outcome == kNotAllowed) GTEST_SKIP() << "needs the right to make a process namespace";
  EXPECT_EQ(outcome, kHeld);
}

TEST(ProcessNameLock, RefusesNamesThatAreNoFileNames) {
  for (const char* name : {"", "a/b", "../a", "a b"}) {
    EXPECT_FALSE(ProcessNameLock::Acquire(name, kUrl).ok()) << name;
  }
}

TEST(ProcessNameLock, TheLongestNameAndPlaceFit) {
  const std::string name = std::string(48, 'a') + Name("");
  EXPECT_TRUE(ProcessNameLock::Acquire(name, "udpm://239.255.255.255:65535").ok());
}

}  // namespace
}  // namespace vantage
