#include "tools/log/log_setup.h"

#include <limits>

#include "bus/log_bus.h"
#include "nodes/config_reader.h"
#include "nodes/estimator_config.h"
#include "tools/support/portable_config.h"

namespace vantage {

Result<LogSetup> ReadLogSetup(const std::filesystem::path& config_file) {
  LogSetup setup;
  if (config_file.empty()) return setup;
  setup.seed = static_cast<int64_t>(EstimatorConfig{}.seed);
  Result<ConfigReader> config = ConfigReader::Open(config_file);
  if (!config) return config.error();
  ConfigReader::Table root = config->Root();
  const std::string estimator = root.Has("ppf") ? "ppf" : "shot";
  ConfigReader::Table table = root.Sub(estimator);
  table.Read("seed", &setup.seed, int64_t{0}, std::numeric_limits<int64_t>::max());
  root.IgnoreAll();
  table.IgnoreAll();
  if (Result<void> read = config->Finish(); !read) return read.error();
  Result<std::string> text =
      PortableConfigText(config->text(), std::filesystem::absolute(config_file).parent_path());
  if (!text) return text.error();
  setup.config_text = std::move(text).value();
  return setup;
}

log_header_t MakeLogHeader(const LogSetup& setup, int64_t utime) {
  log_header_t header{};
  header.utime = utime;
  header.version = VANTAGE_VERSION;
  header.seed = setup.seed;
  header.config_text = setup.config_text;
  FillSchemas(&header);
  return header;
}

}  // namespace vantage
