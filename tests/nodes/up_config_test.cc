#include "nodes/up_config.h"

#include <gtest/gtest.h>

#include <string>

#include "nodes/config_reader.h"

namespace vantage {
namespace {

std::string ErrorOf(const std::string& text) {
  Result<ConfigReader> config = ConfigReader::Parse(text, "x.toml");
  if (!config) return config.error().message;
  ReadUpConfig(*config);
  const Result<void> read = config->Finish();
  return read ? "" : read.error().message;
}

TEST(UpConfig, ReadsProcessesInTheirOrder) {
  Result<ConfigReader> config = ConfigReader::Parse(
      "[up]\nrecord = \"r\"\nlog_files = 2\n[[up.process]]\nname = \"b.1\"\nnice = -5\n"
      "[[up.process]]\nname = \"a\"\ncommand = [\"x\", \"\"]\narguments = [\"--y\"]\nstart = "
      "false\n",
      "x.toml");
  ASSERT_TRUE(config.ok());
  const UpConfig up = ReadUpConfig(*config);
  ASSERT_TRUE(config->Finish().ok());
  EXPECT_TRUE(up.record.is_absolute());
  EXPECT_EQ(up.log_files, 2);
  ASSERT_EQ(up.processes.size(), 2U);
  EXPECT_EQ(up.processes[0].name, "b.1");
  EXPECT_EQ(up.processes[0].nice, -5);
  EXPECT_TRUE(up.processes[0].start);
  EXPECT_EQ(up.processes[1].command, (std::vector<std::string>{"x", ""}));
  EXPECT_EQ(up.processes[1].arguments, std::vector<std::string>{"--y"});
  EXPECT_FALSE(up.processes[1].start);
}

TEST(UpConfig, NamesThatNoSupervisorTakesAreRefused) {
  for (const std::string name : {"", "a b", "a/b", "a:b", "[a]", "a\\n", "all", "ä"}) {
    const std::string error = ErrorOf("[[up.process]]\nname = \"" + name + "\"\n");
    EXPECT_NE(error.find("up.process[0].name"), std::string::npos) << name << ": " << error;
  }
  EXPECT_NE(ErrorOf("[[up.process]]\nname = \"" + std::string(65, 'a') + "\"\n"), "");
  EXPECT_EQ(ErrorOf("[[up.process]]\nname = \"" + std::string(64, 'a') + "\"\n"), "");
}

TEST(UpConfig, WhatMakesNoSenseIsRefused) {
  const std::string twice = ErrorOf("[[up.process]]\nname = \"a\"\n[[up.process]]\nname = \"a\"\n");
  EXPECT_NE(twice.find("expected one [[up.process]] of each name"), std::string::npos) << twice;
  for (const std::string command : {"[]", "[\"\"]"}) {
    const std::string error = ErrorOf("[[up.process]]\nname = \"a\"\ncommand = " + command + "\n");
    EXPECT_NE(error.find("expected the program"), std::string::npos) << error;
  }
  EXPECT_NE(ErrorOf("[up]\nprocess = 1\n").find("[[up.process]]"), std::string::npos);
  EXPECT_NE(ErrorOf("[up]\nrecrod = \"x\"\n").find("unknown key"), std::string::npos);
}

}  // namespace
}  // namespace vantage
