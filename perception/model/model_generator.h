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

/// Names of all objects, in order:
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
std::vector<std::string> GeneratedObjectNames();

/// Always the same mesh for a name. Errors: no such object; the message lists them.
Result<GeneratedObject> GenerateObject(const std::string& name);

}  // namespace vantage
