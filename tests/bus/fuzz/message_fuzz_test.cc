// Damaged messages of every type: nothing crashes (run it under ASan too), and decoding allocates
// in proportion to the bytes that came, not to what their counts claim.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "all_messages.h"
#include "bus/bus.h"
#include "bus/message_schema.h"
#include "bus/wire.h"
#include "tests/bus/fuzz/count_allocations.h"
#include "tests/bus/support/random_message.h"

namespace vantage {
namespace {

// An element takes at most so many times its bytes on the wire: an empty string is 5 there and 32
// in memory.
constexpr size_t kPerByte = 10;
constexpr size_t kConstant = 2048;  // bytes; the error's sentence

template <class Message>
class Fuzzer {
 public:
  Fuzzer() : schema_(*FindSchema(Message::getTypeName())) {}

  void Run() {
    Rng rng(42);
    for (int round = 0; round < 4; ++round) {
      const std::vector<std::byte> sound = RandomMessage(schema_, 1 + round, rng);
      ASSERT_TRUE(Feed(sound));
      Truncations(sound);
      Flips(sound, rng);
      HostileCounts(sound);
      HostileBytes(sound, rng);
    }
  }

 private:
  // True when it was decoded.
  bool Feed(std::span<const std::byte> bytes) {
    const size_t before = BytesAllocated();
    const Result<Message> message = DecodeChecked<Message>(bytes);
    const size_t allocated = BytesAllocated() - before;
    EXPECT_LE(allocated, kPerByte * bytes.size() + kConstant)
        << Message::getTypeName() << " of " << bytes.size() << " bytes";
    if (message) {
      // What passes is consistent: it encodes to as many bytes.
      EXPECT_EQ(static_cast<size_t>(message.value().getEncodedSize()), bytes.size());
    }
    return message.ok();
  }

  void Truncations(std::span<const std::byte> sound) {
    for (size_t size = 0; size < sound.size(); ++size) {
      // A copy of its own, so that ASan sees the first byte that is read too far.
      const std::vector<std::byte> bytes(sound.begin(),
                                         sound.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_FALSE(Feed(bytes)) << Message::getTypeName() << " cut to " << size;
    }
  }

  void Flips(std::vector<std::byte> bytes, Rng& rng) {
    for (size_t i = 0; i < bytes.size(); ++i) {
      const std::byte original = bytes[i];
      for (unsigned bit = 0; bit < 8; ++bit) {
        bytes[i] = original ^ static_cast<std::byte>(1U << bit);
        const bool decoded = Feed(bytes);
        EXPECT_FALSE(decoded && i < 8) << "a flip in the fingerprint";
      }
      bytes[i] = static_cast<std::byte>(rng.Below(256));
      Feed(bytes);
      bytes[i] = original;
    }
  }

  void HostileCounts(std::vector<std::byte> bytes) {
    constexpr std::array<int32_t, 8> kCounts = {
        0x40000000, INT32_MIN, -1, INT32_MAX, 0, 0x10000, 0x20000000, 0x33333333};
    for (size_t i = 8; i + 4 <= bytes.size(); ++i) {
      const std::vector<std::byte> original(bytes.begin() + static_cast<std::ptrdiff_t>(i),
                                            bytes.begin() + static_cast<std::ptrdiff_t>(i + 4));
      for (const int32_t count : kCounts) {
        StoreBigEndian(count, std::span(bytes).subspan(i));
        Feed(bytes);
      }
      std::ranges::copy(original, bytes.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }

  // Random bytes after a good fingerprint, half of them small so that counts are often plausible.
  void HostileBytes(const std::vector<std::byte>& sound, Rng& rng) {
    for (int i = 0; i < 500; ++i) {
      std::vector<std::byte> bytes(sound.begin(), sound.begin() + 8);
      const uint32_t size = rng.Below(600);
      for (uint32_t k = 0; k < size; ++k) {
        const uint32_t value = rng.Below(256);
        bytes.push_back(static_cast<std::byte>(rng.Below(2) == 0 ? value : value % 3));
      }
      Feed(bytes);
    }
  }

  const MessageSchema& schema_;
};

// Counts that just fit are where a decoder allocates most.
template <class Message>
void FeedZeros() {
  const MessageSchema& schema = *FindSchema(Message::getTypeName());
  std::vector<std::byte> bytes(100'000);
  StoreBigEndian(schema.fingerprint(), std::span(bytes));
  for (size_t i = 8; i + 4 <= 400; ++i) {
    for (const int32_t count : {99'000, 49'000, 19'000, 11'000, 3'000, 1'000}) {
      StoreBigEndian(count, std::span(bytes).subspan(i));
      const size_t before = BytesAllocated();
      const bool decoded = DecodeChecked<Message>(bytes).ok();
      EXPECT_LE(BytesAllocated() - before, kPerByte * bytes.size() + kConstant)
          << Message::getTypeName() << " at " << i << ", decoded " << decoded;
      StoreBigEndian(int32_t{0}, std::span(bytes).subspan(i));
    }
  }
}

#define VANTAGE_MESSAGE(type)                                  \
  TEST(MessageFuzz, Survives_##type) { Fuzzer<type>().Run(); } \
  TEST(MessageFuzz, BoundsMemory_##type) { FeedZeros<type>(); }
VANTAGE_FOR_EACH_MESSAGE
#undef VANTAGE_MESSAGE

TEST(MessageFuzz, TheCounterCounts) {
  const size_t before = BytesAllocated();
  const std::vector<int> memory(1000);
  EXPECT_GE(BytesAllocated() - before, memory.size() * sizeof(int));
}

}  // namespace
}  // namespace vantage
