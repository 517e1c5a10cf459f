#pragma once

#include <vector>

#include "common/result.h"
#include "common/so3.h"
#include "perception/model/object_model.h"
#include "perception/ppf/ppf_table.h"
#include "perception/refinement/nearest_grid.h"
#include "perception/verification/drawable_mesh.h"
#include "perception/verification/model_view.h"

namespace vantage {

/// A model beside what the refinement and the verification of its hypotheses need.
struct KnownModel {
  ObjectModel object;
  DrawableMesh mesh;               ///< For the last refinement and verification.
  DrawableMesh coarse_mesh;        ///< To rank hypotheses.
  NearestGrid grid;                ///< For the refinement on points.
  double radius;                   ///< m, about the center
  std::vector<Pose> alternatives;  ///< Poses in which the model looks nearly the same.

  [[nodiscard]] ModelShape Shape() const { return {mesh, object.center, object.diameter, radius}; }
  [[nodiscard]] ModelShape CoarseShape() const {
    return {coarse_mesh, object.center, object.diameter, radius};
  }
};

/// @param table of the model, with which its alternatives are found.
/// Errors: a size that no object has, which is mostly a mesh in another unit than metres.
Result<KnownModel> MakeKnownModel(ObjectModel object, const PpfTable& table);

}  // namespace vantage
