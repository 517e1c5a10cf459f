#include "tools/evaluate/report_files.h"

#include <system_error>

#include "common/format.h"
#include "tools/support/whole_file.h"

namespace vantage {

Result<void> WriteReportFiles(const std::filesystem::path& folder,
                              const ReportFigures& figures,
                              const std::vector<std::pair<std::string, std::string>>& texts) {
  const std::filesystem::path figure_folder = folder / "figures";
  const std::filesystem::path& deepest = figures.empty() ? folder : figure_folder;
  std::error_code error;
  std::filesystem::create_directories(deepest, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 Format("folder %s can't be made: %s", deepest.c_str(), error.message().c_str())};
  }
  for (const auto& [name, figure] : figures) {
    const Result<void> written = WriteWholeFile(figure_folder / (name + ".svg"), figure);
    if (!written) return written;
  }
  for (const auto& [name, text] : texts) {
    if (Result<void> written = WriteWholeFile(folder / name, text); !written) return written;
  }
  return {};
}

}  // namespace vantage
