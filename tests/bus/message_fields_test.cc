#include "bus/message_fields.h"

#include <gtest/gtest.h>

#include <bit>
#include <limits>

#include "all_messages.h"
#include "bus/message_check.h"
#include "bus/wire.h"
#include "tests/bus/support/random_message.h"

namespace vantage {
namespace {

using Event = MessageFields::Event;

// Encodes what was read again, from the decoded values.
class Reencoder {
 public:
  explicit Reencoder(MessageFields fields) : fields_(std::move(fields)) {
    Integer(fields_.schema().fingerprint());
    while (fields_.Next() != Event::kEnd) Take();
  }
  [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }
  [[nodiscard]] int depth() const { return depth_; }

 private:
  template <class T>
  void Integer(T value) {
    bytes_.resize(bytes_.size() + sizeof(T));
    StoreBigEndian(value, std::span(bytes_).last(sizeof(T)));
  }

  void Take() {
    switch (fields_.event()) {
      case Event::kBeginStruct:
      case Event::kBeginArray:
        ++depth_;
        return;
      case Event::kEndStruct:
      case Event::kEndArray:
        --depth_;
        return;
      case Event::kText:
        Integer(static_cast<int32_t>(fields_.text().size() + 1));
        for (const char c : fields_.text()) Integer(static_cast<uint8_t>(c));
        return Integer(uint8_t{0});
      case Event::kNumbers:
        for (size_t i = 0; i < fields_.numbers().size(); ++i) Number(i);
        return;
      case Event::kEnd:
        return;
    }
  }

  void Number(size_t i) {
    const FieldNumbers& numbers = fields_.numbers();
    switch (numbers.kind()) {
      case FieldKind::kFloat:
        return Integer(std::bit_cast<uint32_t>(static_cast<float>(numbers.Real(i))));
      case FieldKind::kDouble:
        return Integer(std::bit_cast<uint64_t>(numbers.Real(i)));
      case FieldKind::kInt16:
        return Integer(static_cast<int16_t>(numbers.Integer(i)));
      case FieldKind::kInt32:
        return Integer(static_cast<int32_t>(numbers.Integer(i)));
      case FieldKind::kInt64:
        return Integer(numbers.Integer(i));
      default:
        return Integer(static_cast<uint8_t>(numbers.Integer(i)));
    }
  }

  MessageFields fields_;
  std::vector<std::byte> bytes_;
  int depth_ = 0;
};

// Random bytes of every type, through the encoder that lcm-gen wrote.
template <class Message>
void ExpectReadsWhole() {
  Rng rng(11);
  for (int max_count = 0; max_count < 6; ++max_count) {
    for (int i = 0; i < 20; ++i) {
      const Result<Message> message = DecodeChecked<Message>(
          RandomMessage(*FindSchema(Message::getTypeName()), max_count, rng));
      ASSERT_TRUE(message.ok());
      const std::vector<std::byte> bytes = Encode(*message);
      Result<MessageFields> fields = MessageFields::Open(bytes);
      ASSERT_TRUE(fields.ok()) << fields.error().message;
      EXPECT_EQ(fields->schema().name, Message::getTypeName());
      const Reencoder again(std::move(fields).value());
      EXPECT_EQ(again.depth(), 0);
      EXPECT_TRUE(again.bytes() == bytes) << Message::getTypeName();
    }
  }
}

#define VANTAGE_MESSAGE(type) \
  TEST(MessageFields, ReadsWhole_##type) { ExpectReadsWhole<type>(); }
VANTAGE_FOR_EACH_MESSAGE
#undef VANTAGE_MESSAGE

// Damaged bytes are refused where CheckMessageBytes refuses them, and else read to their end.
template <class Message>
void ExpectSurvives() {
  const MessageSchema& schema = *FindSchema(Message::getTypeName());
  Rng rng(12);
  for (int round = 0; round < 30; ++round) {
    std::vector<std::byte> bytes = RandomMessage(schema, 3, rng);
    for (int i = 0; i < 20; ++i) {
      std::vector<std::byte> damaged(bytes.begin(), bytes.end() - rng.Below(2));
      for (int k = 0; k < 3; ++k) {
        damaged[rng.Below(static_cast<uint32_t>(damaged.size()))] =
            static_cast<std::byte>(rng.Below(256));
      }
      Result<MessageFields> fields = MessageFields::Open(damaged);
      ASSERT_EQ(fields.ok(), CheckMessageBytes(std::string(schema.name), damaged).ok());
      if (fields) {
        EXPECT_TRUE(Reencoder(std::move(fields).value()).bytes().size() == damaged.size());
      }
    }
  }
}

#define VANTAGE_MESSAGE(type) \
  TEST(MessageFields, SurvivesDamage_##type) { ExpectSurvives<type>(); }
VANTAGE_FOR_EACH_MESSAGE
#undef VANTAGE_MESSAGE

object_estimates_v3_t TwoObjects() {
  object_estimates_v3_t message{};
  message.seq = -7;
  message.num_objects = 2;
  message.objects.resize(2);
  message.objects[1].model_id = "bracket";
  message.objects[1].num_peaks = 1;
  message.objects[1].peaks.resize(1);
  message.objects[1].peaks[0].quat[2] = 0.1;
  return message;
}

TEST(MessageFields, TellsPathsAndStructure) {
  const std::vector<std::byte> bytes = Encode(TwoObjects());
  Result<MessageFields> fields = MessageFields::Open(bytes);
  ASSERT_TRUE(fields.ok());
  std::vector<std::string> seen;
  while (fields->Next() != Event::kEnd) {
    const std::string path = fields->Path();
    switch (fields->event()) {
      case Event::kBeginStruct:
        seen.push_back(path + " {");
        break;
      case Event::kEndStruct:
        seen.push_back(path + " }");
        break;
      case Event::kBeginArray:
        seen.push_back(path + " x" + std::to_string(fields->array_size()));
        break;
      case Event::kEndArray:
        seen.push_back(path + " ]");
        break;
      case Event::kText:
        seen.push_back(path + " '" + std::string(fields->text()) + "'");
        break;
      default:
        if (path == "objects[1].peaks[0].quat") seen.push_back(path + fields->numbers().Text(2));
        if (path == "seq") seen.push_back(path + fields->numbers().Text(0));
    }
  }
  EXPECT_EQ(fields->Path(), "");
  EXPECT_EQ(fields->Next(), Event::kEnd);
  const auto contains = [&seen](const std::string& line) {
    return std::ranges::find(seen, line) != seen.end();
  };
  for (const char* line : {"seq-7",
                           "objects x2",
                           "objects[0] {",
                           "objects[0].peaks x0",
                           "objects[0].peaks ]",
                           "objects[0] }",
                           "objects[1].model_id 'bracket'",
                           "objects[1].peaks[0] {",
                           "objects[1].peaks[0].quat0.1",
                           "objects[1].peaks[0] }",
                           "objects[1].peaks ]",
                           "objects[1] }",
                           "objects ]"}) {
    EXPECT_TRUE(contains(line)) << line;
  }
}

TEST(MessageFields, HandsOverBulkAsOneSpan) {
  image_t image{};
  image.size = 100'000;
  image.data.resize(100'000, 0xab);
  const std::vector<std::byte> bytes = Encode(image);
  Result<MessageFields> fields = MessageFields::Open(bytes);
  ASSERT_TRUE(fields.ok());
  int num_events = 0;
  while (fields->Next() != Event::kEnd) {
    ++num_events;
    if (fields->Path() != "data") continue;
    EXPECT_EQ(fields->numbers().kind(), FieldKind::kByte);
    EXPECT_TRUE(fields->field().is_array);
    ASSERT_EQ(fields->numbers().size(), 100'000U);
    EXPECT_EQ(fields->numbers().Integer(99'999), 0xab);
  }
  EXPECT_LT(num_events, 20);
}

TEST(MessageFields, TextReadsBackToTheSameNumber) {
  const auto text = [](double value) {
    std::array<std::byte, 8> bytes{};
    StoreBigEndian(std::bit_cast<int64_t>(value), std::span(bytes));
    return FieldNumbers(FieldKind::kDouble, bytes).Text(0);
  };
  for (const double value : {0.1, -1.0 / 3, 1e300, 1e-300, 12345678901234567.0, 0.0}) {
    EXPECT_EQ(std::stod(text(value)), value);
  }
  EXPECT_EQ(text(0.1), "0.1");
  EXPECT_EQ(text(std::numeric_limits<double>::quiet_NaN()), "nan");
  EXPECT_EQ(text(-std::numeric_limits<double>::infinity()), "-inf");
}

TEST(MessageFields, RefusesWhatIsNoMessageOfOurs) {
  const std::vector<std::byte> foreign(20, std::byte{9});
  for (size_t size = 0; size <= foreign.size(); ++size) {
    const Result<MessageFields> fields = MessageFields::Open(std::span(foreign).first(size));
    ASSERT_FALSE(fields.ok());
    EXPECT_NE(fields.error().message.find(size < 8 ? "expected at least" : "0909090909090909"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace vantage
