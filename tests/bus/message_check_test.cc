#include "bus/message_check.h"

#include <gtest/gtest.h>

#include <set>

#include "all_messages.h"
#include "bus/message_schema.h"
#include "bus/wire.h"
#include "tests/bus/support/random_message.h"

namespace vantage {
namespace {

template <class Message>
void ExpectRoundTrips() {
  const MessageSchema* schema = FindSchema(Message::getTypeName());
  ASSERT_NE(schema, nullptr) << Message::getTypeName();
  EXPECT_EQ(schema->fingerprint(), Message::getHash());
  EXPECT_EQ(FindSchema(Message::getHash()), schema);
  Rng rng(7);
  for (int max_count = 0; max_count < 6; ++max_count) {
    for (int i = 0; i < 20; ++i) {
      const std::vector<std::byte> bytes = RandomMessage(*schema, max_count, rng);
      const Result<Message> message = DecodeChecked<Message>(bytes);
      ASSERT_TRUE(message.ok()) << message.error().message;
      EXPECT_TRUE(Encode(*message) == bytes) << Message::getTypeName();
    }
  }
}

#define VANTAGE_MESSAGE(type) \
  TEST(MessageCheck, RoundTrips_##type) { ExpectRoundTrips<type>(); }
VANTAGE_FOR_EACH_MESSAGE
#undef VANTAGE_MESSAGE

template <class Message>
size_t DefaultSize() {
  return static_cast<size_t>(Message{}.getEncodedSize());
}

TEST(MessageSchema, MinimalSizeIsThatOfAnEmptyMessage) {
#define VANTAGE_MESSAGE(type) \
  EXPECT_EQ(static_cast<size_t>(FindSchema(#type)->min_size) + 8, DefaultSize<type>()) << #type;
  VANTAGE_FOR_EACH_MESSAGE
#undef VANTAGE_MESSAGE
}

// LCM's fingerprints ignore names, so two types with equal fields could not be told apart.
TEST(MessageSchema, FingerprintsDiffer) {
  std::set<int64_t> fingerprints;
  for (const MessageSchema& schema : AllSchemas()) fingerprints.insert(schema.fingerprint());
  EXPECT_EQ(fingerprints.size(), AllSchemas().size());
}

TEST(MessageSchema, UnknownIsNull) {
  EXPECT_EQ(FindSchema("no_such_t"), nullptr);
  EXPECT_EQ(FindSchema(int64_t{12345}), nullptr);
}

std::vector<std::byte> EncodedMetadata() {
  image_metadata_t message{};
  message.key = "seq";
  message.n = 3;
  message.value = {1, 2, 3};
  return Encode(message);  // 8 fingerprint, 4 + 4 key, 4 + 3 value
}

Result<void> CheckMetadata(std::span<const std::byte> bytes) {
  return CheckMessageBytes("image_metadata_t", bytes);
}

TEST(MessageCheck, RefusesWrongLength) {
  std::vector<std::byte> bytes = EncodedMetadata();
  ASSERT_EQ(bytes.size(), 23U);
  EXPECT_TRUE(CheckMetadata(bytes).ok());
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(CheckMetadata(std::span(bytes).first(size)).ok()) << size;
  }
  bytes.push_back(std::byte{0});
  EXPECT_FALSE(CheckMetadata(bytes).ok());
}

TEST(MessageCheck, RefusesWrongFingerprint) {
  std::vector<std::byte> bytes = EncodedMetadata();
  bytes[3] ^= std::byte{1};
  const Result<void> check = CheckMetadata(bytes);
  ASSERT_FALSE(check.ok());
  EXPECT_NE(check.error().message.find("fingerprint"), std::string::npos);
}

TEST(MessageCheck, RefusesUnknownType) {
  const Result<void> check = CheckMessageBytes("no_such_t", {});
  ASSERT_FALSE(check.ok());
  EXPECT_NE(check.error().message.find("no_such_t"), std::string::npos);
}

TEST(MessageCheck, RefusesBadStrings) {
  for (const int32_t length : {0, -1, 5, 12, INT32_MAX, INT32_MIN}) {
    std::vector<std::byte> bytes = EncodedMetadata();
    StoreBigEndian(length, std::span(bytes).subspan(8));
    EXPECT_FALSE(CheckMetadata(bytes).ok()) << length;
  }
  std::vector<std::byte> bytes = EncodedMetadata();
  bytes[15] = std::byte{'x'};  // the closing NUL
  EXPECT_FALSE(CheckMetadata(bytes).ok());
}

TEST(MessageCheck, RefusesBadCounts) {
  for (const int32_t count : {-1, 2, 4, 0x40000000, INT32_MAX, INT32_MIN}) {
    std::vector<std::byte> bytes = EncodedMetadata();
    StoreBigEndian(count, std::span(bytes).subspan(16));
    EXPECT_FALSE(CheckMetadata(bytes).ok()) << count;
  }
}

}  // namespace
}  // namespace vantage
