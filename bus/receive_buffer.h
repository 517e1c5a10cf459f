#pragma once

#include <cstdint>

namespace vantage {

/// Grows the receive buffers of this process's UDP sockets bound to `port` to `requested` bytes,
/// past the system's limit where the process may, and reads back what it got. LCM does not give its
/// sockets away, so they are found among the open files.
/// @return the smallest buffer of these sockets in bytes, as requests count them (half of what the
/// kernel reports, which includes its bookkeeping); -1 when there is no such socket.
int GrowReceiveBuffers(uint16_t port, int requested);

}  // namespace vantage
