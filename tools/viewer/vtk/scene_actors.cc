#include "tools/viewer/vtk/scene_actors.h"

#include <vtkActor.h>
#include <vtkBillboardTextActor3D.h>
#include <vtkCellArray.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>

namespace vantage {
namespace {

constexpr double kCrease = 40.0;  // deg, from which on an edge stays an edge

void SetColor(vtkProperty& property, Rgb color) {
  property.SetColor(color.r / 255.0, color.g / 255.0, color.b / 255.0);
}

vtkNew<vtkPoints> PointsOf(const std::vector<Eigen::Vector3f>& from) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToFloat();
  points->SetNumberOfPoints(static_cast<vtkIdType>(from.size()));
  for (size_t i = 0; i < from.size(); ++i) {
    points->SetPoint(static_cast<vtkIdType>(i), from[i].cast<double>().eval().data());
  }
  return points;
}

vtkNew<vtkActor> ActorOf(vtkPolyData* data) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  return actor;
}

vtkNew<vtkActor> MeshActor(const SceneMesh& item) {
  vtkNew<vtkPolyData> data;
  data->SetPoints(PointsOf(item.mesh->vertices));
  vtkNew<vtkCellArray> triangles;
  for (const auto& triangle : item.mesh->triangles) {
    const vtkIdType corners[3] = {triangle[0], triangle[1], triangle[2]};
    triangles->InsertNextCell(3, static_cast<const vtkIdType*>(corners));
  }
  data->SetPolys(triangles);
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(data);
  normals->SetFeatureAngle(kCrease);
  normals->ConsistencyOff();
  normals->Update();
  vtkNew<vtkActor> actor = ActorOf(normals->GetOutput());
  vtkNew<vtkMatrix4x4> matrix;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      matrix->SetElement(row, column, item.T_world_mesh.matrix()(row, column));
    }
  }
  actor->SetUserMatrix(matrix);
  SetColor(*actor->GetProperty(), item.color);
  actor->GetProperty()->SetOpacity(item.opacity);
  actor->GetProperty()->SetAmbient(0.25);
  actor->GetProperty()->SetDiffuse(0.8);
  return actor;
}

vtkNew<vtkActor> LineActor(const SceneLine& line) {
  vtkNew<vtkPolyData> data;
  data->SetPoints(PointsOf(line.points));
  vtkNew<vtkCellArray> cells;
  cells->InsertNextCell(static_cast<int>(line.points.size()));
  for (size_t i = 0; i < line.points.size(); ++i) cells->InsertCellPoint(static_cast<vtkIdType>(i));
  data->SetLines(cells);
  vtkNew<vtkActor> actor = ActorOf(data);
  SetColor(*actor->GetProperty(), line.color);
  actor->GetProperty()->SetLineWidth(static_cast<float>(line.width_px));
  actor->GetProperty()->LightingOff();
  return actor;
}

vtkNew<vtkActor> DotsActor(const SceneDots& dots) {
  vtkNew<vtkPolyData> data;
  data->SetPoints(PointsOf(dots.points));
  vtkNew<vtkUnsignedCharArray> colors;
  colors->SetNumberOfComponents(3);
  colors->SetNumberOfTuples(static_cast<vtkIdType>(dots.colors.size()));
  vtkNew<vtkCellArray> cells;
  cells->InsertNextCell(static_cast<int>(dots.points.size()));
  for (size_t i = 0; i < dots.points.size(); ++i) {
    const auto at = static_cast<vtkIdType>(i);
    cells->InsertCellPoint(at);
    colors->SetTypedComponent(at, 0, dots.colors[i].r);
    colors->SetTypedComponent(at, 1, dots.colors[i].g);
    colors->SetTypedComponent(at, 2, dots.colors[i].b);
  }
  data->SetVerts(cells);
  data->GetPointData()->SetScalars(colors);
  vtkNew<vtkActor> actor = ActorOf(data);
  actor->GetProperty()->SetPointSize(static_cast<float>(dots.size_px));
  actor->GetProperty()->LightingOff();
  return actor;
}

vtkNew<vtkBillboardTextActor3D> LabelActor(const SceneLabel& label) {
  vtkNew<vtkBillboardTextActor3D> actor;
  actor->SetInput(label.text.c_str());
  actor->SetPosition(label.at.x(), label.at.y(), label.at.z());
  vtkTextProperty& text = *actor->GetTextProperty();
  text.SetFontSize(13);
  text.BoldOn();
  text.SetJustificationToCentered();
  text.SetVerticalJustificationToCentered();
  text.SetColor(label.color.r / 255.0, label.color.g / 255.0, label.color.b / 255.0);
  return actor;
}

}  // namespace

void FillRenderers(const ViewerScene& scene, vtkRenderer& solid, vtkRenderer& on_top) {
  solid.RemoveAllViewProps();
  on_top.RemoveAllViewProps();
  for (const SceneDots& dots : scene.dots) solid.AddActor(DotsActor(dots));
  for (const SceneLine& line : scene.lines) {
    if (line.points.size() < 2) continue;
    (line.on_top ? on_top : solid).AddActor(LineActor(line));
  }
  for (const SceneMesh& mesh : scene.meshes) {
    (mesh.on_top ? on_top : solid).AddActor(MeshActor(mesh));
  }
  for (const SceneLabel& label : scene.labels) on_top.AddActor(LabelActor(label));
}

}  // namespace vantage
