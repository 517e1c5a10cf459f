// Makes model folders, from our own generator or from a mesh, and shows what is in them.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/format.h"
#include "common/result.h"
#include "fusion/confusion/contingency_file.h"
#include "fusion/symmetry/measured_symmetry.h"
#include "fusion/symmetry/symmetry_weights.h"
#include "fusion/symmetry/table_symmetry.h"
#include "nodes/command_line.h"
#include "perception/model/mesh_check.h"
#include "perception/model/mesh_import.h"
#include "perception/model/model_builder.h"
#include "perception/model/model_generator.h"
#include "perception/model/object_model.h"
#include "perception/model/symmetry_text.h"
#include "perception/ppf/ppf_table.h"
#include "tools/support/model_picture.h"
#include "tools/support/png_image.h"
#include "tools/support/whole_file.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTableName = "ppf.bin";
constexpr const char* kMeasured = "measured";

struct Arguments {
  std::vector<std::string> names;
  std::string mesh;
  std::string unit;
  std::string id;
  std::string symmetry = "none";
  std::string folder;
  std::string output;
  std::string table;
  std::string weights;
  bool tables = true;
};

// The model with its matching table, or neither.
Result<void> SaveWithTable(const ObjectModel& model, const fs::path& folder, bool tables) {
  if (!tables) return SaveObjectModel(model, folder);
  const Result<PpfTable> table =
      PpfTable::Train(model.samples, model.diameter, PpfTableParameters{});
  if (!table) return table.error();
  return SaveObjectModel(model, folder, [&table, &model](const fs::path& place) {
    return table->Save(place / kTableName, model.mesh_hash);
  });
}

void PrintSummary(const ObjectModel& model) {
  std::printf("%s: %zu vertices, %zu triangles, diameter %.1f mm, %zu samples, symmetry %s\n",
              model.id.c_str(),
              model.mesh.vertices.size(),
              model.mesh.triangles.size(),
              1e3 * model.diameter,
              model.samples.size(),
              SymmetryText(model.symmetry).c_str());
}

Result<void> Generate(const Arguments& arguments) {
  std::vector<std::string> names = arguments.names;
  if (names.empty()) names = GeneratedObjectNames();
  // All of them before the first is written: a wrong name leaves nothing behind.
  std::vector<ObjectModel> models;
  for (const std::string& name : names) {
    Result<GeneratedObject> object = GenerateObject(name);
    if (!object) return object.error();
    Result<ObjectModel> model = BuildObjectModel(
        name, object->mesh, object->symmetry, "vantage-model generate " + name, {});
    if (!model) return model.error();
    models.push_back(std::move(model).value());
  }
  for (const ObjectModel& model : models) {
    Result<void> saved =
        SaveWithTable(model, fs::path(arguments.output) / model.id, arguments.tables);
    if (!saved) return saved;
    PrintSummary(model);
  }
  return {};
}

void PrintMending(const MeshMending& mending) {
  if (mending.merged_vertices > 0) {
    std::printf("merged %zu vertices that were at another one's place\n", mending.merged_vertices);
  }
  if (mending.removed_triangles > 0) {
    std::printf("left out %zu triangles with two corners in one place\n",
                mending.removed_triangles);
  }
  if (mending.open_edges > 0) {
    std::printf("the mesh is open: %zu edges belong to one triangle only\n", mending.open_edges);
  }
  if (mending.odd_edges > 0) {
    std::printf("%zu edges belong to triangles that disagree on what is outside\n",
                mending.odd_edges);
  }
  if (mending.flipped) std::printf("the mesh was inside out: turned all triangles\n");
}

void PrintFound(const FoundSymmetry& found, double diameter) {
  std::printf("%s", FoundSymmetryText(found).c_str());
  constexpr double kFarOff = 0.01;
  std::printf("axes pass   %.2f mm from the center (%.2f %% of the diameter)%s\n",
              1e3 * found.center_offset,
              100.0 * found.center_offset / diameter,
              found.center_offset > kFarOff * diameter
                  ? ": the mesh is uneven, mind the positions of turned copies"
                  : "");
}

Result<void> Build(const Arguments& arguments) {
  const fs::path file = arguments.mesh;
  fs::path folder = fs::path(arguments.output).lexically_normal();
  if (folder.filename().empty()) folder = folder.parent_path();
  const std::string id = arguments.id.empty() ? folder.filename().string() : arguments.id;
  if (Result<void> fits = CheckModelId(id); !fits) return fits;
  if (id != folder.filename()) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("--output %s and --id %s, expected the folder's name to be the id",
                        arguments.output.c_str(),
                        id.c_str())};
  }
  const bool is_measured = arguments.symmetry == kMeasured;
  Result<SymmetryGroup> symmetry =
      is_measured ? SymmetryGroup::None() : ParseSymmetry(arguments.symmetry);
  if (!symmetry) return symmetry.error();
  Result<TriangleMesh> mesh = ImportMesh(file, arguments.unit == "mm" ? 1e-3 : 1.0);
  if (!mesh) return mesh.error();
  const Result<MeshMending> mending = CheckAndMendMesh(&*mesh);
  if (!mending) {
    return Error{mending.error().code, file.string() + ": " + mending.error().message};
  }
  FoundSymmetry found;
  if (is_measured) {
    const Result<FoundSymmetry> measured = MeasureSymmetry(*mesh);
    if (!measured) {
      return Error{measured.error().code, file.string() + ": " + measured.error().message};
    }
    found = *measured;
    symmetry = found.group;
  }
  const std::string source = file.filename().string() + ", unit " + arguments.unit;
  const Result<ObjectModel> model =
      BuildObjectModel(id, std::move(mesh).value(), *symmetry, source, {});
  if (!model) return model.error();
  Result<void> saved = SaveWithTable(*model, folder, arguments.tables);
  if (!saved) return saved;
  PrintMending(*mending);
  PrintSummary(*model);
  if (is_measured) PrintFound(found, model->diameter);
  if (found.is_sphere) {
    std::printf(
        "the object is the same from all sides; the model says continuous about z with "
        "flips, which is the most that it can: use its position, not its orientation\n");
  }
  return {};
}

Result<void> Info(const Arguments& arguments) {
  const fs::path folder = arguments.folder;
  const Result<ObjectModel> loaded = LoadObjectModel(folder);
  if (!loaded) return loaded.error();
  const ObjectModel& model = *loaded;
  const Eigen::AlignedBox3f box = model.mesh.Bounds();
  const Eigen::Vector3f size = 1e3F * box.sizes();
  std::printf("id          %s\n", model.id.c_str());
  std::printf("source      %s\n", model.source.c_str());
  std::printf("mesh        %zu vertices, %zu triangles, hash %016jx\n",
              model.mesh.vertices.size(),
              model.mesh.triangles.size(),
              uintmax_t{model.mesh_hash});
  std::printf("size        %.1f x %.1f x %.1f mm\n",
              static_cast<double>(size.x()),
              static_cast<double>(size.y()),
              static_cast<double>(size.z()));
  std::printf("diameter    %.1f mm\n", 1e3 * model.diameter);
  std::printf("center      %.1f %.1f %.1f mm\n",
              1e3 * model.center.x(),
              1e3 * model.center.y(),
              1e3 * model.center.z());
  std::printf("symmetry    %s\n", SymmetryText(model.symmetry).c_str());
  std::printf("samples     %zu\n", model.samples.size());
  std::error_code error;
  if (!fs::exists(folder / kTableName, error)) {
    std::printf("ppf table   none; made when it is needed\n");
    return {};
  }
  const Result<PpfTable> table = PpfTable::Load(folder / kTableName, model.mesh_hash);
  if (!table) return table.error();
  std::printf("ppf table   %zu points, %zu pairs\n", table->points().size(), table->num_entries());
  return {};
}

Result<void> Picture(const Arguments& arguments) {
  const Result<ObjectModel> model = LoadObjectModel(arguments.folder);
  if (!model) return model.error();
  if (Result<void> written = WritePng(arguments.output, RenderModelPicture(*model)); !written) {
    return written;
  }
  std::printf("wrote %s\n", arguments.output.c_str());
  return {};
}

struct NamedMesh {
  TriangleMesh mesh;
  ContingencyKey key;  // What its contingency tables must be of; of a mesh file empty.
};

// A mesh file's with its unit, or a model folder's.
Result<NamedMesh> MeshOf(const Arguments& arguments) {
  NamedMesh named;
  const auto wrong = [&arguments](const char* what) {
    return Error{ErrorCode::kInvalidArgument, arguments.mesh + what};
  };
  std::error_code error;
  if (!fs::exists(arguments.mesh, error)) return wrong(": no such model folder or mesh");
  if (fs::is_directory(arguments.mesh, error)) {
    Result<ObjectModel> model = LoadObjectModel(arguments.mesh);
    if (!model) return model.error();
    named.key.model_id = model->id;
    named.key.mesh_hash = Format("%016jx", uintmax_t{model->mesh_hash});
    named.mesh = std::move(model->mesh);
    return named;
  }
  if (arguments.unit.empty()) return wrong(" is a mesh, expected --unit mm or --unit m with it");
  if (!arguments.table.empty()) return wrong(" is a mesh, expected a model folder with --table");
  Result<TriangleMesh> mesh = ImportMesh(arguments.mesh, arguments.unit == "mm" ? 1e-3 : 1.0);
  if (!mesh) return mesh.error();
  const Result<MeshMending> mending = CheckAndMendMesh(&*mesh);
  if (!mending) return Error{mending.error().code, arguments.mesh + ": " + mending.error().message};
  named.mesh = std::move(mesh).value();
  return named;
}

// One representative orientation a line; those that weigh nothing are left out.
Result<void> WriteWeights(const std::string& file,
                          const So3Grid& grid,
                          const std::vector<SymmetryWeight>& weights,
                          const char* source) {
  std::string text = "source,x,y,z,w,angle_deg,weight\n";
  for (const auto& [cell, weight] : weights) {
    if (weight < 1e-6) continue;
    const Eigen::Quaterniond q = grid.Representative(cell);
    text += Format("%s,%.6f,%.6f,%.6f,%.6f,%.3f,%.6g\n",
                   source,
                   q.x(),
                   q.y(),
                   q.z(),
                   q.w(),
                   GeodesicAngle(q, Eigen::Quaterniond::Identity()) / kDegree,
                   weight);
  }
  return WriteWholeFile(file, text);
}

std::string GroupText(const FoundSymmetry& found) {
  return found.is_sphere ? "a sphere" : SymmetryText(found.group);
}

// All is read, measured and written before anything is told.
Result<void> Symmetry(const Arguments& arguments) {
  const Result<NamedMesh> named = MeshOf(arguments);
  if (!named) return named.error();
  std::optional<ContingencyTable> table;
  if (!arguments.table.empty()) {
    Result<ContingencyTable> read = ReadContingencyTable(arguments.table);
    if (!read) return read.error();
    table = std::move(read).value();
    Result<void> fits = CheckContingencyKey(table->key, named->key, arguments.table);
    if (!fits) return fits;
  }
  const Result<FoundSymmetry> from_mesh = MeasureSymmetry(named->mesh);
  if (!from_mesh) return from_mesh.error();
  const Result<FoundSymmetry> from_table = table ? SymmetryOfTable(*table) : FoundSymmetry{};
  if (!from_table) return from_table.error();
  if (!arguments.weights.empty()) {
    constexpr int kOfWeights = 8;  // As the paper's figure 6.
    const So3Grid grid(kOfWeights);
    const auto weights =
        table ? TableSymmetryWeights(*table, grid) : Result(MeshSymmetryWeights(named->mesh, grid));
    if (!weights) return weights.error();
    const char* source = table ? "table" : "mesh";
    Result<void> written = WriteWeights(arguments.weights, grid, *weights, source);
    if (!written) return written;
  }
  std::printf("from the mesh: %s\n", GroupText(*from_mesh).c_str());
  PrintFound(*from_mesh, named->mesh.Diameter());
  if (table) {
    std::printf("from the table of %s and %s: %s\n%s",
                table->key.model_id.c_str(),
                table->key.estimator.c_str(),
                GroupText(*from_table).c_str(),
                FoundSymmetryText(*from_table).c_str());
  }
  if (!arguments.weights.empty()) std::printf("wrote %s\n", arguments.weights.c_str());
  return {};
}

int Run(int argc, char** argv) {
  CLI::App app("Makes model folders and shows what is in them.", "vantage-model");
  app.require_subcommand(1);
  Arguments arguments;

  CLI::App* generate = app.add_subcommand("generate", "make the bundled objects, all or by name");
  generate->add_option("name", arguments.names, "objects to make; all when none is named");
  generate->add_option("--output", arguments.output, "folder to put the model folders in")
      ->required();

  CLI::App* build = app.add_subcommand("build", "make a model folder of a PLY, OBJ or STL mesh");
  build->add_option("mesh", arguments.mesh, "the mesh")->required();
  build->add_option("--unit", arguments.unit, "unit of the mesh's coordinates, mm or m")
      ->required()
      ->check(CLI::IsMember({"mm", "m"}));
  build->add_option(
      "--id", arguments.id, "the model's name; that of the output folder when left out");
  build->add_option("--symmetry",
                    arguments.symmetry,
                    "none, cyclic:2:z, dihedral:2:z:x, continuous:z or continuous-flip:z; "
                    "measured: found from the mesh");
  build->add_option("--output", arguments.output, "the model folder to make")->required();
  for (CLI::App* command : {generate, build}) {
    command->add_flag("!--no-tables", arguments.tables, "leave the matching tables out");
  }

  CLI::App* info = app.add_subcommand("info", "print what a model folder holds");
  info->add_option("folder", arguments.folder, "the model folder")->required();

  CLI::App* picture = app.add_subcommand("picture", "draw a model");
  picture->add_option("folder", arguments.folder, "the model folder")->required();
  picture->add_option("--output", arguments.output, "the PNG file to write")->required();

  CLI::App* symmetry = app.add_subcommand(
      "symmetry", "measure the symmetry of a model folder or a mesh, and of a contingency table");
  symmetry->add_option("mesh", arguments.mesh, "the model folder or the mesh")->required();
  symmetry->add_option("--unit", arguments.unit, "unit of a mesh's coordinates, mm or m")
      ->check(CLI::IsMember({"mm", "m"}));
  symmetry->add_option("--table", arguments.table, "contingency table of the object");
  symmetry->add_option("--weights",
                       arguments.weights,
                       "CSV file to write the symmetry weights to: the table's, else the mesh's");

  if (const std::optional<int> code = ParseCommandLine(app, argc, argv)) return *code;
  const Result<void> done = *generate   ? Generate(arguments)
                            : *build    ? Build(arguments)
                            : *info     ? Info(arguments)
                            : *symmetry ? Symmetry(arguments)
                                        : Picture(arguments);
  if (!done) {
    std::fprintf(stderr, "vantage-model: %s\n", done.error().message.c_str());
    return 2;
  }
  return 0;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) { return vantage::Run(argc, argv); }
