#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/result.h"

namespace vantage {

/// Where messages travel: udpm://ADDRESS:PORT?OPTIONS (UDP multicast), or memq:// (inside one
/// process, for tests).
struct LcmUrl {
  enum class Provider { kUdpMulticast, kMemory };

  static constexpr const char* kDefault = "udpm://239.255.76.67:7667?ttl=0";

  Provider provider = Provider::kUdpMulticast;
  std::string address = "239.255.76.67";
  uint16_t port = 7667;
  std::vector<std::pair<std::string, std::string>> options;  ///< such as ttl, recv_buf_size

  /// Errors: another provider, an address that is no IPv4 multicast group, a port outside
  /// 1..65535, options without a value.
  static Result<LcmUrl> Parse(const std::string& text);
  /// `text`, or LCM_DEFAULT_URL of the environment, or kDefault: the first that is not empty.
  static Result<LcmUrl> ParseOrDefault(const std::string& text);

  /// The value of an option; empty when it is absent.
  [[nodiscard]] std::string Option(const std::string& key) const;
  /// Sets an option unless the URL has it.
  void SetDefault(const std::string& key, const std::string& value);
  [[nodiscard]] std::string Text() const;
  /// Group and port without options: what makes two URLs the same place.
  [[nodiscard]] std::string Place() const;
};

}  // namespace vantage
