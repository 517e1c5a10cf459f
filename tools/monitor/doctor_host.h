#pragma once

#include <filesystem>

#include "tools/monitor/doctor_finding.h"
#include "tools/monitor/system_view.h"

namespace vantage {

DoctorFinding CheckClockSynchronized(const SystemView& system);
/// The year, which messages refuse outside of 1970 to 2200 and a dead battery sets to 1970.
DoctorFinding CheckClockYear(const SystemView& system);
DoctorFinding CheckClockSource(const SystemView& system);
/// The wall clock was not set while the stalls were measured.
DoctorFinding CheckClockStep(const SystemView& system, const SystemView::Stalls& stalls);

/// By how long the processor was late for a process that slept.
DoctorFinding CheckStalls(const SystemView::Stalls& stalls);
DoctorFinding CheckLoad(const SystemView& system);
DoctorFinding CheckGovernor(const SystemView& system);
/// RLIMIT_RTPRIO: chrt -f is allowed.
DoctorFinding CheckRealTimePriority(const SystemView& system);
/// RLIMIT_MEMLOCK
DoctorFinding CheckLockedMemory(const SystemView& system);

/// Room for recordings. @param folder absolute.
DoctorFinding CheckDisk(const SystemView& system, const std::filesystem::path& folder);
/// `java -version`, for lcm-spy.
DoctorFinding CheckJava(const SystemView& system);
/// The jars of LCM, of the charts, and ours. @param programs folder of our programs.
DoctorFindings CheckJars(const SystemView& system, const std::filesystem::path& programs);
/// supervisord or systemd, for vantage-up.
DoctorFinding CheckSupervisor(const SystemView& system);
/// A screen, and the graphics card, for the viewer.
DoctorFinding CheckDisplay(const SystemView& system);
DoctorFinding CheckGraphics(const SystemView& system);

}  // namespace vantage
