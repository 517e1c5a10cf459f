// vantage-stages: draws what each stage of the point pair estimator makes of one depth image of a
// log, and tells why a model was not found in it.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "common/format.h"
#include "nodes/command_line.h"
#include "nodes/estimator_config.h"
#include "nodes/ppf_config.h"
#include "perception/model/file_bytes.h"
#include "tools/support/log_config.h"
#include "tools/support/stage_image.h"
#include "tools/support/stage_page.h"
#include "tools/support/stage_pictures.h"
#include "tools/support/stage_text.h"
#include "tools/support/stage_trace.h"

namespace vantage {
namespace {

struct Arguments {
  std::string log;
  std::string config;
  std::string output;
  std::optional<int> image;
  std::optional<int> cluster;
};

/// The cluster to enlarge: the asked one, or the largest; nothing when there are none.
Result<std::optional<size_t>> ChooseCluster(const StageTrace& trace, std::optional<int> asked) {
  const size_t count = trace.clusters.size();
  if (!asked) return count > 0 ? std::optional<size_t>(0) : std::nullopt;
  if (*asked < 0 || static_cast<size_t>(*asked) >= count) {
    return Error{ErrorCode::kInvalidArgument,
                 count == 0
                     ? Format("--cluster %d, but the image has no clusters", *asked)
                     : Format("--cluster %d, expected 0 to %zu, the image's", *asked, count - 1)};
  }
  return std::optional<size_t>(*asked);
}

Result<void> Draw(const Arguments& arguments) {
  Result<ConfigReader> reader = OpenConfig(arguments.config, arguments.log);
  if (!reader) return reader.error();
  const Result<PpfConfig> config = ReadPpfConfig(*reader);
  if (!config) return config.error();
  const Result<StageImage> image =
      ReadStageImage(arguments.log, config->camera, arguments.image, config->rest_window_s);
  if (!image) return image.error();
  Result<std::vector<PpfModel>> models = LoadPpfModels(config->models, config->estimator.table);
  if (!models) return models.error();
  const Result<StageTrace> trace =
      TraceStages(std::move(models).value(), config->estimator, *image, config->seed);
  if (!trace) return trace.error();
  const Result<std::optional<size_t>> cluster = ChooseCluster(*trace, arguments.cluster);
  if (!cluster) return cluster.error();

  const PoseEstimatorParameters& estimation = config->estimator.estimation;
  const std::vector<StagePanel> panels = DrawStages(
      *trace, *image, estimation.verification, estimation.segmentation.min_height, *cluster);
  const Result<std::string> page = RenderStagePage(panels);
  if (!page) return page.error();
  if (Result<void> written = WriteFileBytes(arguments.output, *page); !written) return written;
  std::printf("%s", DescribeStages(*trace, *image, estimation.verification).c_str());
  return {};
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app(
      "Draws what each stage of the point pair estimator makes of one depth image, and tells what "
      "became of each model",
      "vantage-stages");
  app.add_option("--log", arguments.log, "LCM event log with the images")->required();
  app.add_option("--config,-c",
                 arguments.config,
                 "TOML file of the set-up; default: the one in the log's LOG_HEADER");
  app.add_option("--image",
                 arguments.image,
                 "which of the images taken at rest, from 1; default: the first with detections");
  app.add_option(
      "--cluster", arguments.cluster, "index of the cluster to enlarge; default: 0, the largest");
  app.add_option("--output,-o", arguments.output, "PNG to write")->required();
  if (const std::optional<int> code = vantage::ParseCommandLine(app, argc, argv)) return *code;
  if (const vantage::Result<void> done = vantage::Draw(arguments); !done) {
    std::fprintf(stderr, "vantage-stages: %s\n", done.error().message.c_str());
    return 2;
  }
  return 0;
}
