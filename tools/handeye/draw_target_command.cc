#include "tools/handeye/draw_target_command.h"

#include <cstdio>
#include <filesystem>

#include "common/format.h"
#include "tools/support/html.h"
#include "tools/support/png_image.h"
#include "tools/support/whole_file.h"

namespace vantage {
namespace {

constexpr double kInch = 0.0254;  // m

RgbImage Colored(const GrayImage& gray) {
  RgbImage image{gray.width, gray.height, {}};
  image.rgb.reserve(3 * gray.pixels.size());
  for (const uint8_t value : gray.pixels) image.rgb.insert(image.rgb.end(), 3, value);
  return image;
}

// The picture at its size in millimeters, which printers heed.
Result<std::string> Svg(const GrayImage& gray, const Eigen::Vector2d& size) {
  const Result<std::vector<uint8_t>> png = EncodePng(Colored(gray));
  if (!png) return png.error();
  return Format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.3fmm\" height=\"%.3fmm\" "
             "viewBox=\"0 0 %d %d\"><image width=\"%d\" height=\"%d\" "
             "style=\"image-rendering:pixelated\" href=\"",
             1e3 * size.x(),
             1e3 * size.y(),
             gray.width,
             gray.height,
             gray.width,
             gray.height) +
         DataUri("image/png", *png) + "\"/></svg>\n";
}

}  // namespace

DrawTargetCommand::DrawTargetCommand(CLI::App* app)
    : command_(app->add_subcommand("draw-target", "draw a target to print")) {
  target_.AddTo(command_);
  command_->add_option("--dpi", dots_per_inch_, "resolution of the picture")
      ->check(CLI::Range(10.0, 2400.0))
      ->capture_default_str();
  command_->add_option("--output", output_, "FILE.svg, which has its size in it, or FILE.png")
      ->required();
}

Result<int> DrawTargetCommand::Run() const {
  const Result<std::optional<CalibrationTarget>> target = target_.Read();
  if (!target) return target.error();
  if (!*target) return Error{ErrorCode::kInvalidArgument, "expected --target"};
  const std::filesystem::path file = output_;
  if (file.extension() != ".svg" && file.extension() != ".png") {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s, expected FILE.svg or FILE.png", file.c_str())};
  }
  const Result<GrayImage> image = DrawTarget(**target, dots_per_inch_ / kInch);
  if (!image) return image.error();
  const Eigen::Vector2d size = (*target)->BoardSize();
  if (file.extension() == ".svg") {
    const Result<std::string> svg = Svg(*image, size);
    if (!svg) return svg.error();
    if (Result<void> written = WriteWholeFile(file, *svg); !written) return written.error();
  } else if (Result<void> written = WritePng(file, Colored(*image)); !written) {
    return written.error();
  }
  std::printf("wrote %s: %.1f x %.1f mm with its margin, print it at %.0f dpi without scaling\n",
              file.c_str(),
              1e3 * size.x(),
              1e3 * size.y(),
              dots_per_inch_);
  return 0;
}

}  // namespace vantage
