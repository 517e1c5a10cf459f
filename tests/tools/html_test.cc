#include "tools/support/html.h"

#include <gtest/gtest.h>

#include <vector>

#include "common/rng.h"
#include "tests/tools/base64.h"

namespace vantage {
namespace {

std::span<const uint8_t> Bytes(std::string_view text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

TEST(EscapeHtml, LeavesNothingThatEndsTextOrAttribute) {
  EXPECT_EQ(EscapeHtml("a<b> & \"c\" 'd'"), "a&lt;b&gt; &amp; &quot;c&quot; &#39;d&#39;");
  EXPECT_EQ(EscapeHtml("&amp;"), "&amp;amp;");
  EXPECT_EQ(EscapeHtml(""), "");
  EXPECT_EQ(EscapeHtml("2\xC2\xB0 \xE2\x80\x93 ok"), "2\xC2\xB0 \xE2\x80\x93 ok");
}

TEST(EscapeHtml, ReplacesControlCharacters) {
  EXPECT_EQ(EscapeHtml("a\nb\tc\r"), "a\nb\tc\r");
  const std::string replacement = "\xEF\xBF\xBD";
  EXPECT_EQ(EscapeHtml(std::string_view("\0\x1b\x7f", 3)), replacement + replacement + replacement);
}

TEST(Base64, IsThatOfRfc4648) {
  // Its section 10.
  EXPECT_EQ(Base64(Bytes("")), "");
  EXPECT_EQ(Base64(Bytes("f")), "Zg==");
  EXPECT_EQ(Base64(Bytes("fo")), "Zm8=");
  EXPECT_EQ(Base64(Bytes("foo")), "Zm9v");
  EXPECT_EQ(Base64(Bytes("foob")), "Zm9vYg==");
  EXPECT_EQ(Base64(Bytes("fooba")), "Zm9vYmE=");
  EXPECT_EQ(Base64(Bytes("foobar")), "Zm9vYmFy");
  EXPECT_EQ(Base64(Bytes("\xff\xef\xfe\xfb")), "/+/++w==");
}

TEST(Base64, ComesBack) {
  Rng rng(1);
  for (size_t length = 0; length < 300; ++length) {
    std::vector<uint8_t> bytes(length);
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(rng.Below(256));
    const std::string text = Base64(bytes);
    EXPECT_EQ(text.size() % 4, 0U);
    EXPECT_EQ(DecodeBase64(text), bytes) << length;
  }
}

TEST(DataUri, NamesTypeAndEncoding) {
  EXPECT_EQ(DataUri("image/svg+xml", "foo"), "data:image/svg+xml;base64,Zm9v");
  EXPECT_EQ(DataUri("image/png", Bytes("fo")), "data:image/png;base64,Zm8=");
}

}  // namespace
}  // namespace vantage
