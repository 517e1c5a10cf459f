#include "tools/support/whole_file.h"

#include "common/format.h"
#include "perception/model/file_bytes.h"

namespace vantage {

Result<void> WriteWholeFile(const std::filesystem::path& file, const std::string& text) {
  const std::filesystem::path part = file.string() + ".part";
  if (Result<void> written = WriteFileBytes(part, text); !written) return written;
  std::error_code error;
  std::filesystem::rename(part, file, error);
  if (!error) return {};
  const std::string message = error.message();
  std::filesystem::remove(part, error);
  return Error{ErrorCode::kIo, Format("%s can't be written: %s", file.c_str(), message.c_str())};
}

}  // namespace vantage
