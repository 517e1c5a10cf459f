#include "nodes/openni2_config.h"

#include <gtest/gtest.h>

#include <string>

#include "nodes/process.h"

namespace vantage {
namespace {

// The config, or the sentence that says why not.
struct Outcome {
  Openni2Config config;
  std::string error;
};

Outcome Read(const std::string& keys) {
  Result<ConfigReader> reader =
      ConfigReader::Parse("[camera.XTION]\ndevice = \"index:0\"\n" + keys, "x.toml");
  if (!reader) return {{}, reader.error().message};
  const Result<Openni2Config> config = ReadOpenni2Config(*reader, "openni2");
  if (!config) return {{}, config.error().message};
  IgnoreTablesOfOthers(*reader);
  const Result<void> finished = reader->Finish();
  return {*config, finished ? std::string() : finished.error().message};
}

TEST(Openni2Config, RecordsNothingUnlessAskedTo) {
  EXPECT_EQ(Read("").error, "");
  EXPECT_TRUE(Read("").config.record_file.empty());
  const Outcome recorded = Read("record_oni = \"/tmp/a.oni\"\n");
  EXPECT_EQ(recorded.error, "");
  EXPECT_EQ(recorded.config.record_file, "/tmp/a.oni");
  EXPECT_EQ(recorded.config.camera.name, "XTION");
}

TEST(Openni2Config, WhatOpenni2CannotDoIsRefused) {
  EXPECT_EQ(Read("color_encoding = \"mjpeg\"\n").error, "");
  EXPECT_NE(Read("color = true\ncolor_encoding = \"mjpeg\"\n").error.find("no JPEG images"),
            std::string::npos);
  Result<ConfigReader> reader = ConfigReader::Parse(
      "[camera.XTION]\ndevice = \"oni:a.oni\"\nrecord_oni = \"b.oni\"\n", "x.toml");
  ASSERT_TRUE(reader.ok());
  EXPECT_TRUE(ReadOpenni2Config(*reader, "openni2").ok());
  IgnoreTablesOfOthers(*reader);
  const Result<void> finished = reader->Finish();
  ASSERT_FALSE(finished.ok());
  EXPECT_NE(finished.error().message.find("record_oni"), std::string::npos);
}

TEST(Openni2Config, KeysOfOtherDriversAreUnknown) {
  EXPECT_NE(Read("pixel_format = \"Z16\"\n").error.find("pixel_format"), std::string::npos);
}

}  // namespace
}  // namespace vantage
