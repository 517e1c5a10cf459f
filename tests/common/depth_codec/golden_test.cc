// A payload that was written once decodes for ever to the same image.
#include <gtest/gtest.h>

#include <string_view>

#include "common/depth_codec/depth_decoder.h"

namespace vantage {
namespace {

constexpr int kWidth = 40;
constexpr int kHeight = 25;

// Version 1.
constexpr std::string_view kPayload =
    "564443012a752bb428001900010800bc02010008040810204080c0bf7407000000001d1e"
    "26030000002700002d000000000000000000000000000000000000000000000000032800"
    "0032000028050000002c2f2d2d052b1b1b2d2f2e28040000002d2d002c00000000000000"
    "000425000000312d2b032f201c2f2c2926042a00002d2d2d29042c221f2a2e2d2d001d21"
    "2b2c2a292c042b00002f2d252b013130000000000000000000000000ba82690186c01200"
    "964001009c80075347010100510102001844010094426c00cd410a0084c27f015d430700"
    "2fa2170496c1020040c31102444224012e4002004b820200a04313000402540057810400"
    "c1d1f78ac4ea0600c4ea0600c4ea0600c4ea0600c4ea0600c4ea0600c4ea0600c4ea0600"
    "c4ea0600c4ea0600c4ea06004600010091030b04eec2146ea981290002021200c8810400"
    "687ba5628ec12c0084c10f00294470029f01040018c1d40b2442ba1261013c0380020700"
    "87813100944312001471d1dd9d80480a1e045f2dae7a2414acfd0500acfd0500acfd0500"
    "acfd0500acfd0500acfd0500acfd0500acfd0500acfd0500acfd0500acfd050060dec39b"
    "07a05e3e1912735f457cf99162e2a3d176f82f63d7685129b7be7ed0a3dbc5308c396079"
    "397091313ec9fab1c9b2db312752d9c650d5072b3ced26acfa795ec6822183eadd8f6451"
    "44f5ec03ad4d961451b26b5b900061a52bf649d1b447831cd0c530401e32569e224c5a5d"
    "3a2eecc47297ec3784865020ec0d65e5d37a5465ae90d4c48595e371b07235d89902dc17"
    "df056b68cdb6e1cf20ca944db812ac15616297c51115e904653a1ae72eeb4cf92b1433b3"
    "d08485646092a2cc5f4ea40cdafe298c2e5989c664eb76d91990e9647c4eceeb49b10d28"
    "144c81dd1ddf58cdc453ec5af32750a33cdde9ed4b1252dfd158d4bc25cd1a82a61a2031"
    "2ca79f68c2507a4579b01ef15489b39c6733be5fd9a61466e22a8021d14e5e9cb8b9448b"
    "3fe55a641749a309c943ce09ec8fb3b59943b16be8944050009fd9ae201218726cdcc2a0"
    "34168faeaea8749646da0aef0b2147821929c30565b74051d43e1469b5081220d99ce048"
    "046654b5d401c412349d3c67e300dd80d9ca";

std::vector<uint8_t> Payload() {
  std::vector<uint8_t> bytes;
  for (size_t i = 0; i < kPayload.size(); i += 2) {
    bytes.push_back(
        static_cast<uint8_t>(std::stoi(std::string(kPayload.substr(i, 2)), nullptr, 16)));
  }
  return bytes;
}

uint16_t Expected(int u, int v) {
  if ((u + v) % 17 == 0) return 3000;
  if ((u * 7 + v * 13) % 11 == 0) return 0;
  return static_cast<uint16_t>(700 + 3 * ((u * u + 5 * v * u) / 64 % 7));
}

TEST(GoldenDepth, DecodesAsEver) {
  for (const DepthKernels& kernels : AvailableDepthKernels()) {
    std::vector<uint16_t> depth;
    const Result<void> result = DepthDecoder(kernels).Decode(Payload(), kWidth, kHeight, &depth);
    ASSERT_TRUE(result) << result.error().message;
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        ASSERT_EQ(depth[static_cast<size_t>(v * kWidth + u)], Expected(u, v)) << u << ", " << v;
      }
    }
  }
}

}  // namespace
}  // namespace vantage
