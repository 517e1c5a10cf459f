#include "tools/contingency/trial_simulator.h"

#include <gtest/gtest.h>

namespace vantage {
namespace {

TEST(TrialSimulator, Builds) {}

}  // namespace
}  // namespace vantage
