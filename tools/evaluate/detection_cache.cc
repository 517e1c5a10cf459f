#include "tools/evaluate/detection_cache.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "tools/evaluate/detection_text.h"
#include "tools/support/hash.h"

namespace vantage {
namespace {

std::string Header(const DetectionFileContent& content) {
  return "vantage detections\n" + content.key + "sequences\n";
}

}  // namespace

std::string DetectionFileContent::FileName() const {
  return Format(
      "%s-%s-%016jx.txt", model_id.c_str(), Name(kind).c_str(), static_cast<uintmax_t>(Fnv1a(key)));
}

Result<DetectionCache> DetectionCache::Open(const std::filesystem::path& folder,
                                            const DetectionFileContent& content) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return Error{ErrorCode::kIo,
                 Format("%s can't be made: %s", folder.c_str(), error.message().c_str())};
  }
  Result<GrowingFile> opened = GrowingFile::Open(folder / content.FileName());
  if (!opened) return opened.error();
  DetectionCache cache(std::move(opened).value(), content);
  if (Result<void> loaded = cache.Load(); !loaded) return loaded.error();
  return cache;
}

DetectionCache::DetectionCache(GrowingFile file, DetectionFileContent content)
    : file_(std::move(file)), content_(std::move(content)) {}

Result<void> DetectionCache::Load() {
  const Result<std::string> bytes = file_.Read();
  if (!bytes) return bytes.error();
  const std::string_view text = *bytes;
  const Result<size_t> header_end = CheckHeader(text);
  if (!header_end) return header_end.error();
  for (size_t position = *header_end; position < text.size();) {
    const SequenceText first = FirstSequenceText(text.substr(position));
    const bool is_last = position + first.record.size() == text.size();
    if (first.is_whole) {
      if (Result<void> taken = Take(text, position); !taken) return taken;
    } else if (is_last) {
      note_ = Format("%s, line %td: the last record is not whole and is made again",
                     file_.path().c_str(),
                     LineAt(text, position));
      return file_.CutTo(position);
    } else {
      return Error{ErrorCode::kCorrupt,
                   Format("%s, line %td: the record from here does not agree with its checksum, "
                          "expected it whole; remove the file to make it again",
                          file_.path().c_str(),
                          LineAt(text, position))};
    }
    position += first.record.size();
  }
  return {};
}

// Where the header ends. It is written when all that is there is a part of it.
Result<size_t> DetectionCache::CheckHeader(std::string_view text) {
  const std::string header = Header(content_);
  if (text.substr(0, header.size()) == header) return header.size();
  const auto [differ, unused] =
      std::mismatch(text.begin(), text.end(), header.begin(), header.end());
  if (differ == text.end()) {
    if (!text.empty())
      note_ = Format("%s: its head is not whole and is made again", file_.path().c_str());
    if (Result<void> cut = file_.CutTo(0); !cut) return cut.error();
    if (Result<void> written = file_.Append(header); !written) return written.error();
    return header.size();
  }
  const auto position = static_cast<size_t>(differ - text.begin());
  return Error{ErrorCode::kCorrupt,
               Format("%s, line %td: \"%s\", expected \"%s\"; remove the file to make it again",
                      file_.path().c_str(),
                      LineAt(text, position),
                      LineAround(text, position).c_str(),
                      LineAround(header, position).c_str())};
}

// Takes the whole record at a position.
Result<void> DetectionCache::Take(std::string_view text, size_t position) {
  size_t line = 0;
  Result<DetectionSequence> sequence =
      ParseSequenceText(FirstSequenceText(text.substr(position)).record, &line);
  std::string wrong;
  if (!sequence) {
    wrong = sequence.error().message;
  } else if (static_cast<size_t>(sequence->index) != sequences_.size()) {
    wrong = Format("is of sequence %d, expected %zu", sequence->index, sequences_.size());
  } else if (sequence->views.size() != static_cast<size_t>(content_.num_views)) {
    wrong = Format("begins %zu views, expected %d", sequence->views.size(), content_.num_views);
  }
  if (!wrong.empty()) {
    return Error{ErrorCode::kCorrupt,
                 Format("%s, line %td %s; remove the file to make it again",
                        file_.path().c_str(),
                        LineAt(text, position) + static_cast<std::ptrdiff_t>(line),
                        wrong.c_str())};
  }
  sequence->model_id = content_.model_id;
  for (DetectedView& view : sequence->views) {
    for (Detection& detection : view.detections) detection.model_id = content_.model_id;
  }
  sequences_.push_back(std::move(sequence).value());
  return {};
}

Result<void> DetectionCache::Append(DetectionSequence sequence) {
  VANTAGE_CHECK(static_cast<size_t>(sequence.index) == sequences_.size() &&
                    sequence.views.size() == static_cast<size_t>(content_.num_views),
                Format("sequence %d with %zu views", sequence.index, sequence.views.size()));
  std::string text;
  AppendSequenceText(sequence, &text);
  if (Result<void> written = file_.Append(text); !written) return written;
  sequences_.push_back(std::move(sequence));
  return {};
}

}  // namespace vantage
