#pragma once

#include "perception/model/object_model.h"

namespace vantage {

/// Radius of the ball about the model's center that holds its mesh, m.
double RadiusAboutCenter(const ObjectModel& model);

}  // namespace vantage
