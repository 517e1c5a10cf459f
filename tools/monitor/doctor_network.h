#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bus/lcm_url.h"
#include "tools/monitor/bus_probe.h"
#include "tools/monitor/doctor_finding.h"
#include "tools/monitor/system_view.h"

namespace vantage {

/// The interface that messages leave by: there is one, it is up, and it reaches others if the URL
/// means others (ttl above 0).
DoctorFinding CheckMulticastRoute(const SystemView& system, const LcmUrl& url);
/// Messages to oneself come back.
DoctorFinding CheckRoundTrip(const BusProbe& probe);
/// What the kernel granted of the receive buffer that was asked for.
DoctorFinding CheckReceiveBuffer(const SystemView& system, const BusProbe& probe);
/// net.core.rmem_max. @param wanted bytes.
DoctorFinding CheckLargestBuffer(const SystemView& system, int64_t wanted);
/// net.core.rmem_default, which is what programs have that ask for none, as lcm-spy.
DoctorFinding CheckDefaultBuffer(const SystemView& system);
/// Who has sockets on the URL's port.
DoctorFinding CheckPort(const SystemView& system, const LcmUrl& url);
/// Of each expected process whether it runs; and names that are taken twice, or by one that is
/// silent.
DoctorFindings CheckProcessNames(const SystemView& system,
                                 const BusProbe& probe,
                                 const std::vector<std::string>& expected);

}  // namespace vantage
