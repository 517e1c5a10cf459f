#pragma once

#include <string>

#include "vantage/object_estimates_v3_t.hpp"

namespace vantage {

/// Objects as a table for people: model, instance, state, pose (m and degrees about x, y, z of the
/// rotation vector), views.
std::string ObjectTable(const object_estimates_v3_t& objects);

}  // namespace vantage
