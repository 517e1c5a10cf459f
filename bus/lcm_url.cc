#include "bus/lcm_url.h"

#include <arpa/inet.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>

#include "common/format.h"

namespace vantage {
namespace {

Error Malformed(const std::string& text, const std::string& why) {
  return {ErrorCode::kInvalidArgument,
          Format("LCM URL '%s': %s, expected udpm://ADDRESS:PORT?ttl=0 such as %s",
                 text.c_str(),
                 why.c_str(),
                 LcmUrl::kDefault)};
}

bool IsMulticast(const std::string& address) {
  in_addr parsed{};
  return inet_pton(AF_INET, address.c_str(), &parsed) == 1 && (ntohl(parsed.s_addr) >> 28U) == 0xeU;
}

Result<void> ParseOptions(const std::string& text, const std::string& list, LcmUrl* url) {
  for (size_t begin = 0; begin < list.size();) {
    const size_t end = std::min(list.find('&', begin), list.size());
    const std::string option = list.substr(begin, end - begin);
    const size_t equals = option.find('=');
    if (equals == 0 || equals == std::string::npos || equals + 1 == option.size()) {
      return Malformed(text, "option '" + option + "' is not KEY=VALUE");
    }
    url->options.emplace_back(option.substr(0, equals), option.substr(equals + 1));
    begin = end + 1;
  }
  for (const char* key : {"ttl", "recv_buf_size"}) {
    const std::string value = url->Option(key);
    if (value.find_first_not_of("0123456789") != std::string::npos || value.size() > 9) {
      return Malformed(text, Format("%s is '%s', no number", key, value.c_str()));
    }
  }
  return {};
}

Result<void> ParsePlace(const std::string& text, const std::string& place, LcmUrl* url) {
  const size_t colon = place.find(':');
  if (colon != 0 && !place.empty()) url->address = place.substr(0, colon);
  if (!IsMulticast(url->address)) {
    return Malformed(text, "'" + url->address + "' is no IPv4 multicast address");
  }
  if (colon == std::string::npos) return {};
  const std::string port = place.substr(colon + 1);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), url->port);
  if (error != std::errc() || end != port.data() + port.size() || url->port == 0) {
    return Malformed(text, "'" + port + "' is no port from 1 to 65535");
  }
  return {};
}

}  // namespace

Result<LcmUrl> LcmUrl::Parse(const std::string& text) {
  LcmUrl url;
  const size_t question = std::min(text.find('?'), text.size());
  const std::string head = text.substr(0, question);
  const std::string list = question < text.size() ? text.substr(question + 1) : "";
  if (head == "memq://") {
    url.provider = Provider::kMemory;
  } else if (head.starts_with("udpm://")) {
    if (Result<void> place = ParsePlace(text, head.substr(7), &url); !place) return place.error();
  } else {
    return Malformed(text, "its provider is neither udpm:// nor memq://");
  }
  if (Result<void> options = ParseOptions(text, list, &url); !options) return options.error();
  return url;
}

Result<LcmUrl> LcmUrl::ParseOrDefault(const std::string& text) {
  if (!text.empty()) return Parse(text);
  const char* variable = std::getenv("LCM_DEFAULT_URL");
  return Parse(variable != nullptr && *variable != '\0' ? variable : kDefault);
}

std::string LcmUrl::Option(const std::string& key) const {
  const auto found = std::ranges::find(options, key, &std::pair<std::string, std::string>::first);
  return found == options.end() ? std::string() : found->second;
}

void LcmUrl::SetDefault(const std::string& key, const std::string& value) {
  if (Option(key).empty()) options.emplace_back(key, value);
}

std::string LcmUrl::Text() const {
  if (provider == Provider::kMemory) return "memq://";
  std::string text = Place();
  for (size_t i = 0; i < options.size(); ++i) {
    text += (i == 0 ? '?' : '&') + options[i].first + '=' + options[i].second;
  }
  return text;
}

std::string LcmUrl::Place() const {
  if (provider == Provider::kMemory) return "memq://";
  return Format("udpm://%s:%d", address.c_str(), port);
}

}  // namespace vantage
