#include "perception/estimator/known_model.h"

#include <algorithm>
#include <utility>

#include "common/format.h"
#include "perception/model/enclosing_ball.h"
#include "perception/ppf/self_alignment.h"
#include "perception/verification/mesh_decimation.h"

namespace vantage {
namespace {

constexpr double kGridReach = 0.16;  // Of the diameter; beyond the coarse refinement's pairs.
constexpr double kGridCell = 0.02;   // Of the diameter.
constexpr size_t kGridPoints = 4000;
constexpr uint64_t kGridSeed = 1;
constexpr uint64_t kSelfSeed = 2;
constexpr double kSmallest = 0.005;  // m, diameter; a depth camera does not resolve less.
constexpr double kLargest = 5.0;     // m

NearestGrid MakeGrid(const ObjectModel& model) {
  Rng rng(kGridSeed);
  return NearestGrid(SampleSurface(model.mesh, kGridPoints, rng),
                     kGridReach * model.diameter,
                     kGridCell * model.diameter);
}

}  // namespace

Result<KnownModel> MakeKnownModel(ObjectModel object, const PpfTable& table) {
  if (!(object.diameter >= kSmallest && object.diameter <= kLargest)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("model \"%s\" has a diameter of %g m, expected %g to %g m: is its mesh in "
                        "millimetres, or scaled twice?",
                        object.id.c_str(),
                        object.diameter,
                        kSmallest,
                        kLargest)};
  }
  DrawableMesh mesh(DecimateMesh(object.mesh, kFineLevel));
  DrawableMesh coarse(DecimateMesh(object.mesh, kCoarseLevel));
  const double radius = RadiusAboutCenter(object);
  NearestGrid grid = MakeGrid(object);
  Rng rng(kSelfSeed);
  std::vector<Pose> alternatives = FindSelfAlignments(
      table, grid, ModelShape{mesh, object.center, object.diameter, radius}, object.symmetry, rng);
  return KnownModel{std::move(object),
                    std::move(mesh),
                    std::move(coarse),
                    std::move(grid),
                    radius,
                    std::move(alternatives)};
}

}  // namespace vantage
