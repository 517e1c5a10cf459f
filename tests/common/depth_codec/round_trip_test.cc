// Every image comes back as it was.
#include <gtest/gtest.h>

#include "common/depth_codec/depth_decoder.h"
#include "common/depth_codec/depth_encoder.h"

namespace vantage {
namespace {

TEST(DepthCodec, KeepsASmallImage) {
  const std::vector<uint16_t> depth = {0, 1, 2, 65535, 700, 700};
  const std::vector<uint8_t> payload = DepthEncoder().Encode(3, 2, depth);
  std::vector<uint16_t> decoded;
  const Result<void> result = DepthDecoder().Decode(payload, 3, 2, &decoded);
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_EQ(decoded, depth);
}

}  // namespace
}  // namespace vantage
