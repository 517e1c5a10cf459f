#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "common/symmetry_group.h"
#include "common/triangle_mesh.h"

namespace vantage {

/// An object that this project makes itself, so that there are models without any download.
struct GeneratedObject {
  std::string name;
  std::string what;        ///< For people.
  TriangleMesh mesh;       ///< m, base at z = 0
  SymmetryGroup symmetry;  ///< Exact, but that round bodies are polygons of 48 or more corners.
};

/// Which of the objects.
enum class ObjectSet {
  kBundled,    ///< in models/
  kAmbiguous,  ///< symmetric but for one feature of 10 to 20 mm that most directions hide
};

/// Names of the objects of a set, in order. The bundled ones:
///   filter   no symmetry but for one boss 2-fold, like an oil filter's housing
///   shampoo  2-fold about z
///   hub      no symmetry but for one boss 4-fold
///   trefoil  3-fold about z
///   carton   half turns about x, y and z
///   bottle   continuous about z
///   mug      no symmetry: continuous but for its handle
///   bracket  no symmetry
///   gear     6-fold about z
///   duck     no symmetry, free-form
///   cat      no symmetry, free-form
///   dwarf    no symmetry, free-form
///   fish     no symmetry, free-form; left and right alike
///   pitcher  no symmetry: continuous but for its lip and its handle
///   pony     no symmetry, free-form
///   sauce    no symmetry but for a thumb rest 2-fold
///   spray    no symmetry: its body is 2-fold, its head is not
///   turtle   no symmetry, free-form; left and right alike
/// The ambiguous ones, all without symmetry, and what they had without the feature:
///   flange   6-fold
///   cross    4-fold
///   valve    3-fold
///   brick    half turns about x, y and z
///   plug     2-fold
///   knob     continuous
///   cap      continuous
///   star     5-fold
///   nut      6-fold, and upside down
///   reel     continuous, and upside down
std::vector<std::string> GeneratedObjectNames(ObjectSet set = ObjectSet::kBundled);

/// Always the same mesh for a name. Errors: no such object; the message lists them.
Result<GeneratedObject> GenerateObject(const std::string& name);

}  // namespace vantage
