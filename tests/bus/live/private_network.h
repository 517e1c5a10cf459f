#pragma once

namespace vantage {

/// Moves this process, which has one thread, into a new network with nothing but loopback. False
/// when the system forbids it.
bool EnterPrivateNetwork(bool with_route);

/// The program runs in one.
bool HasPrivateNetwork();

}  // namespace vantage

/// Skips a test that may not send anything outside.
#define VANTAGE_NEEDS_PRIVATE_NETWORK()                                         \
  if (!::vantage::HasPrivateNetwork()) {                                        \
    GTEST_SKIP() << "needs the right to make a network namespace (unshare -n)"; \
  }
