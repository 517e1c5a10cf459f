#pragma once

#include "perception/model/object_model.h"
#include "tools/support/png_image.h"

namespace vantage {

/// A model from two sides on a table, 960 x 480 px.
RgbImage RenderModelPicture(const ObjectModel& model);

}  // namespace vantage
