#pragma once

#include <OpenNI.h>
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "drivers/sim/fault_state.h"

namespace vantage {

/// Calls a sim_test_ function of the plugin that OpenNI2 has loaded.
template <class... Arguments>
void Command(const char* name, Arguments... arguments) {
  Dl_info library{};
  ASSERT_NE(dladdr(reinterpret_cast<void*>(oniInitialize), &library), 0);
  const std::filesystem::path plugin = std::filesystem::path(library.dli_fname).parent_path() /
                                       "OpenNI2/Drivers/libVantageSimTest.so.0";
  void* handle = dlopen(plugin.c_str(), RTLD_NOW | RTLD_NOLOAD);
  ASSERT_NE(handle, nullptr) << "OpenNI2 has not loaded " << plugin;
  auto* function = reinterpret_cast<void (*)(Arguments...)>(dlsym(handle, name));
  ASSERT_NE(function, nullptr);
  function(arguments...);
  dlclose(handle);
}

inline void Fault(SimFault::Kind kind, double duration = 0.0) {
  Command("sim_test_fault", static_cast<int>(kind), duration);
}

}  // namespace vantage
