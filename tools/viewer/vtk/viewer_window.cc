#include "tools/viewer/vtk/viewer_window.h"

#include <vtkActor2D.h>
#include <vtkAutoInit.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkImageData.h>
#include <vtkImageMapper.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkLightKit.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkProperty2D.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkSliderRepresentation2D.h>
#include <vtkSliderWidget.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tools/viewer/vtk/scene_actors.h"

// Which of VTK's libraries are behind its abstract classes.
VTK_MODULE_INIT(vtkRenderingOpenGL2)
VTK_MODULE_INIT(vtkRenderingFreeType)
VTK_MODULE_INIT(vtkInteractionStyle)

namespace vantage {
namespace {

constexpr double kViewAngle = 30.0;  // deg
constexpr int kTickMs = 33;

// Turning and zooming by mouse as usual; all keys are the viewer's.
class MouseOnly : public vtkInteractorStyleTrackballCamera {
 public:
  static MouseOnly* New();
  vtkTypeMacro(MouseOnly, vtkInteractorStyleTrackballCamera) void OnChar() override {}
};
vtkStandardNewMacro(MouseOnly)

    // The sides of a box of pixels as VTK counts them: shares of the window, from below.
    void SetViewport(const PixelBox& box, int width, int height, vtkRenderer& renderer) {
  renderer.SetViewport(static_cast<double>(box.x) / width,
                       1.0 - static_cast<double>(box.bottom()) / height,
                       static_cast<double>(box.right()) / width,
                       1.0 - static_cast<double>(box.y) / height);
}

// As near as all points are in the picture.
void LookAtAll(const std::vector<Eigen::Vector3d>& points, double aspect, vtkRenderer& renderer) {
  if (points.empty()) return;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : points) box.extend(point);
  const Eigen::Vector3d back = Eigen::Vector3d(0.62, -1.0, 0.55).normalized();
  const Eigen::Vector3d right = Eigen::Vector3d::UnitZ().cross(back).normalized();
  const Eigen::Vector3d up = back.cross(right);
  const double tangent = 0.92 * std::tan(0.5 * kViewAngle * kDegree);
  double distance = 0.05;  // m
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d from = point - box.center();
    const double needed =
        std::max(std::abs(from.dot(right)) / aspect, std::abs(from.dot(up))) / tangent;
    distance = std::max(distance, from.dot(back) + needed);
  }
  const Eigen::Vector3d center = box.center();
  const Eigen::Vector3d eye = center + distance * back;
  vtkCamera& camera = *renderer.GetActiveCamera();
  camera.SetFocalPoint(center.x(), center.y(), center.z());
  camera.SetPosition(eye.x(), eye.y(), eye.z());
  camera.SetViewUp(0.0, 0.0, 1.0);
  camera.SetViewAngle(kViewAngle);
}

vtkNew<vtkImageData> ImageOf(const RgbImage& image) {
  vtkNew<vtkImageData> data;
  data->SetDimensions(image.width, image.height, 1);
  data->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  const size_t row = 3 * static_cast<size_t>(image.width);
  for (int v = 0; v < image.height; ++v) {
    std::memcpy(data->GetScalarPointer(0, image.height - 1 - v, 0),
                image.rgb.data() + row * static_cast<size_t>(v),
                row);
  }
  return data;
}

}  // namespace

struct ViewerWindow::Impl {
  vtkNew<vtkRenderWindow> window;
  vtkNew<vtkRenderer> page;  // Below all: the picture and its texts.
  vtkNew<vtkRenderer> scene;
  vtkNew<vtkRenderer> scene_on_top;
  vtkNew<vtkRenderer> closeup;
  vtkNew<vtkRenderer> closeup_on_top;
  vtkNew<vtkRenderer> controls;  // Above all: the slider.
  vtkNew<vtkImageMapper> picture;
  vtkNew<vtkRenderWindowInteractor> interactor;
  vtkNew<vtkSliderWidget> slider;
  vtkNew<vtkSliderRepresentation2D> slider_shape;
  vtkNew<vtkCallbackCommand> events;
  Handlers handlers;

  void AddRenderer(vtkRenderer& renderer, int layer) {
    renderer.SetLayer(layer);
    window->AddRenderer(&renderer);
  }
  void ShowPage(const Page& shown);
  void OnEvent(unsigned long event);
};

ViewerWindow::ViewerWindow(int width, int height, bool is_offscreen)
    : impl_(std::make_unique<Impl>()) {
  Impl& m = *impl_;
  m.window->SetOffScreenRendering(is_offscreen ? 1 : 0);
  m.window->SetSize(width, height);
  m.window->SetMultiSamples(4);
  m.window->SetWindowName("vantage-viewer");
  m.window->SetNumberOfLayers(6);
  m.AddRenderer(*m.page, 0);
  m.AddRenderer(*m.scene, 1);
  m.AddRenderer(*m.scene_on_top, 2);
  m.AddRenderer(*m.closeup, 3);
  m.AddRenderer(*m.closeup_on_top, 4);
  m.AddRenderer(*m.controls, 5);
  m.closeup->SetPreserveColorBuffer(0);
  m.closeup->SetBackground(1.0, 1.0, 1.0);
  m.scene_on_top->SetActiveCamera(m.scene->GetActiveCamera());
  m.closeup_on_top->SetActiveCamera(m.closeup->GetActiveCamera());
  m.page->InteractiveOff();
  m.scene_on_top->InteractiveOff();
  m.closeup_on_top->InteractiveOff();
  m.controls->InteractiveOff();
  for (vtkRenderer* renderer :
       {m.scene.Get(), m.scene_on_top.Get(), m.closeup.Get(), m.closeup_on_top.Get()}) {
    vtkNew<vtkLightKit> lights;
    lights->AddLightsToRenderer(renderer);
  }
  m.picture->SetColorWindow(255.0);
  m.picture->SetColorLevel(127.5);
}

ViewerWindow::~ViewerWindow() = default;

void ViewerWindow::Impl::ShowPage(const Page& shown) {
  page->RemoveAllViewProps();
  picture->SetInputData(ImageOf(shown.image));
  vtkNew<vtkActor2D> background;
  background->SetMapper(picture);
  page->AddActor2D(background);
  for (const PageText& text : shown.texts) {
    if (text.text.empty()) continue;
    vtkNew<vtkTextActor> actor;
    actor->SetInput(text.text.c_str());
    actor->SetDisplayPosition(static_cast<int>(text.x),
                              static_cast<int>(shown.image.height - text.y));
    vtkTextProperty& property = *actor->GetTextProperty();
    property.SetFontSize(text.size_px);
    property.SetBold(text.bold ? 1 : 0);
    property.SetColor(text.color.r / 255.0, text.color.g / 255.0, text.color.b / 255.0);
    property.SetVerticalJustificationToCentered();
    if (text.side == TextSide::kCenter) property.SetJustificationToCentered();
    if (text.side == TextSide::kRight) property.SetJustificationToRight();
    page->AddActor2D(actor);
  }
}

void ViewerWindow::Show(const ViewerScene& scene, const Page& page) {
  Impl& m = *impl_;
  const WindowLayout layout = LayOut(page.image.width, page.image.height);
  SetViewport(layout.scene, page.image.width, page.image.height, *m.scene);
  SetViewport(layout.scene, page.image.width, page.image.height, *m.scene_on_top);
  SetViewport(layout.closeup, page.image.width, page.image.height, *m.closeup);
  SetViewport(layout.closeup, page.image.width, page.image.height, *m.closeup_on_top);
  m.ShowPage(page);
  FillRenderers(scene, *m.scene, *m.scene_on_top);
  FillRenderers(scene, *m.closeup, *m.closeup_on_top);
  m.scene->ResetCameraClippingRange();
  m.closeup->ResetCameraClippingRange();
  if (m.window->GetOffScreenRendering() == 0) m.window->Render();
}

void ViewerWindow::LookAtOverview(const std::vector<Eigen::Vector3d>& points) {
  const WindowLayout layout = LayOut(width(), height());
  LookAtAll(points, static_cast<double>(layout.scene.width) / layout.scene.height, *impl_->scene);
}

void ViewerWindow::LookAtCloseup(const std::vector<Eigen::Vector3d>& points) {
  LookAtAll(points, 1.0, *impl_->closeup);
}

RgbImage ViewerWindow::Grab() {
  impl_->window->Render();
  vtkNew<vtkWindowToImageFilter> filter;
  filter->SetInput(impl_->window);
  filter->SetInputBufferTypeToRGB();
  filter->ReadFrontBufferOff();
  filter->ShouldRerenderOff();
  filter->Update();
  vtkImageData& data = *filter->GetOutput();
  RgbImage image;
  image.width = data.GetDimensions()[0];
  image.height = data.GetDimensions()[1];
  const size_t row = 3 * static_cast<size_t>(image.width);
  image.rgb.resize(row * static_cast<size_t>(image.height));
  for (int v = 0; v < image.height; ++v) {
    std::memcpy(image.rgb.data() + row * static_cast<size_t>(v),
                data.GetScalarPointer(0, image.height - 1 - v, 0),
                row);
  }
  return image;
}

int ViewerWindow::width() const { return impl_->window->GetSize()[0]; }
int ViewerWindow::height() const { return impl_->window->GetSize()[1]; }

void ViewerWindow::Impl::OnEvent(unsigned long event) {
  if (event == vtkCommand::TimerEvent && handlers.on_tick) handlers.on_tick();
  if (event == vtkCommand::KeyPressEvent && handlers.on_key) {
    const char* key = interactor->GetKeySym();
    if (key != nullptr) handlers.on_key(key);
  }
  if (event == vtkCommand::InteractionEvent && handlers.on_slider) {
    handlers.on_slider(slider_shape->GetValue());
  }
}

void ViewerWindow::Run(const Handlers& handlers, bool with_slider) {
  Impl& m = *impl_;
  m.handlers = handlers;
  m.interactor->SetRenderWindow(m.window);
  vtkNew<MouseOnly> style;
  m.interactor->SetInteractorStyle(style);
  m.interactor->Initialize();
  m.events->SetClientData(&m);
  m.events->SetCallback([](vtkObject*, unsigned long event, void* client, void*) {
    static_cast<Impl*>(client)->OnEvent(event);
  });
  m.interactor->AddObserver(vtkCommand::TimerEvent, m.events);
  m.interactor->AddObserver(vtkCommand::KeyPressEvent, m.events);
  if (with_slider) {
    m.slider_shape->SetMinimumValue(0.0);
    m.slider_shape->SetMaximumValue(1.0);
    m.slider_shape->ShowSliderLabelOff();
    m.slider_shape->SetSliderLength(0.012);
    m.slider_shape->SetSliderWidth(0.02);
    m.slider_shape->SetTubeWidth(0.004);
    m.slider_shape->SetEndCapLength(0.0);
    m.slider_shape->GetSliderProperty()->SetColor(0.17, 0.24, 0.36);
    m.slider_shape->GetSelectedProperty()->SetColor(0.78, 0.09, 0.38);
    m.slider_shape->GetTubeProperty()->SetColor(0.7, 0.72, 0.76);
    const WindowLayout layout = LayOut(width(), height());
    const double y = 1.0 - (layout.scene.bottom() - 16.0) / height();
    m.slider_shape->GetPoint1Coordinate()->SetCoordinateSystemToNormalizedDisplay();
    m.slider_shape->GetPoint1Coordinate()->SetValue(0.02, y);
    m.slider_shape->GetPoint2Coordinate()->SetCoordinateSystemToNormalizedDisplay();
    m.slider_shape->GetPoint2Coordinate()->SetValue(
        static_cast<double>(layout.scene.right()) / width() - 0.02, y);
    m.slider->SetInteractor(m.interactor);
    m.slider->SetRepresentation(m.slider_shape);
    m.slider->SetAnimationModeToJump();
    m.slider->SetCurrentRenderer(m.controls);
    m.slider->EnabledOn();
    m.slider->AddObserver(vtkCommand::InteractionEvent, m.events);
  }
  m.interactor->CreateRepeatingTimer(kTickMs);
  m.interactor->Start();
}

void ViewerWindow::Close() { impl_->interactor->TerminateApp(); }

void ViewerWindow::SetSlider(double place) { impl_->slider_shape->SetValue(place); }

}  // namespace vantage
