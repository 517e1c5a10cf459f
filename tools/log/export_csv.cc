#include <map>
#include <utility>
#include <vector>

#include "bus/message_fields.h"
#include "bus/message_schema.h"
#include "bus/wire.h"
#include "common/format.h"
#include "tools/log/export_output.h"
#include "tools/log/log_exporter.h"
#include "tools/support/csv_field.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr size_t kFlushBytes = 1U << 16U;
constexpr size_t kMostTables = 2000;  // Names of channels come from outside.
constexpr size_t kMostInACell = 64;   // Values of a list of numbers.

bool IsBytes(const SchemaField& field) {
  return field.kind == FieldKind::kByte && field.count_from >= 0;
}

// A list of other types or of texts gets a table of its own.
bool HasTable(const SchemaField& field) {
  return field.is_array && (field.kind == FieldKind::kNested || field.kind == FieldKind::kString);
}

// Appends the columns of a type's members.
void AppendColumns(const MessageSchema& schema, const std::string& prefix, std::string* head) {
  for (const SchemaField& field : schema.fields) {
    if (HasTable(field) || IsBytes(field)) continue;
    const std::string name = prefix + std::string(field.name);
    if (field.kind == FieldKind::kNested) {
      AppendColumns(*field.nested, name + ".", head);
    } else if (field.is_array && field.count_from < 0) {
      for (int64_t i = 0; i < field.fixed_count; ++i) {
        *head += Format(",%s[%jd]", name.c_str(), intmax_t{i});
      }
    } else {
      head->append(",").append(name);
    }
  }
}

struct Table {
  fs::path file;
  std::string waiting;
  int64_t num_rows = 0;
};

// A line that is being written, of the message or of an element of a list in it.
struct Line {
  std::string table;  // Path of the lists: "", "objects", "objects.peaks"
  std::string text;
  int64_t next_element = 0;  // Of the list that is being read.
};

class CsvExporter : public LogExporter {
 public:
  explicit CsvExporter(std::unique_ptr<ExportFolder> folder) : folder_(std::move(folder)) {}

  Result<void> Add(const LogEventView& event, bool wanted) override;
  Result<std::string> Finish() override;

 private:
  Result<void> AddRows(const std::string& name, const LogEventView& event, MessageFields* fields);
  Result<void> Commit(const std::string& name,
                      const Line& line,
                      const std::vector<std::string>& keys,
                      const std::string& columns);
  void AppendNumbers(const MessageFields& fields, std::string* text);
  static Result<void> Flush(Table* table);

  std::unique_ptr<ExportFolder> folder_;
  std::map<std::string, std::string, std::less<>> types_;  // First type by channel.
  std::map<std::string, Table> tables_;                    // By file's name.
  std::map<std::string, int64_t> foreign_;                 // Messages left out by channel.
  int64_t num_malformed_ = 0;
  int64_t num_long_lists_ = 0;
  int64_t num_bytes_left_out_ = 0;
};

Result<void> CsvExporter::Add(const LogEventView& event, bool wanted) {
  if (!wanted) return {};
  const bool has_type = event.data.size() >= sizeof(int64_t);
  const MessageSchema* schema = has_type ? FindSchema(LoadBigEndian<int64_t>(event.data)) : nullptr;
  if (schema == nullptr) {
    if (foreign_.size() < kMostTables) ++foreign_[std::string(event.channel)];
    return {};
  }
  Result<MessageFields> fields = MessageFields::Open(event.data);
  if (!fields) {
    ++num_malformed_;
    return {};
  }
  const auto first = types_.try_emplace(std::string(event.channel), schema->name).first;
  std::string name = FileNameOf(event.channel);
  if (first->second != schema->name) name.append("~").append(schema->name);
  return AddRows(name, event, &*fields);
}

Result<void> CsvExporter::AddRows(const std::string& name,
                                  const LogEventView& event,
                                  MessageFields* fields) {
  const std::string key = Format("%jd", intmax_t{event.number});
  std::vector<Line> lines = {
      {.table = "", .text = key + Format(",%jd", intmax_t{event.utime}), .next_element = 0}};
  std::vector<std::string> keys = {"event"};
  std::string head = "event,event_utime_us";
  AppendColumns(fields->schema(), "", &head);
  using Event = MessageFields::Event;
  while (fields->Next() != Event::kEnd) {
    const bool starts_line = fields->is_element() && fields->event() != Event::kEndStruct;
    if (fields->event() == Event::kBeginArray) lines.back().next_element = 0;
    if (starts_line) {
      Line& parent = lines.back();
      const std::string list(fields->field().name);
      Line line;
      line.table = parent.table + (parent.table.empty() ? "" : ".") + list;
      // The keys of the parent's line, and this element's place.
      size_t end = 0;
      for (size_t i = 0; i < keys.size(); ++i) end = parent.text.find(',', end + 1);
      line.text = parent.text.substr(0, end) + Format(",%jd", intmax_t{parent.next_element++});
      keys.push_back(list);
      lines.push_back(std::move(line));
    }
    if (fields->event() == Event::kNumbers && !IsBytes(fields->field())) {
      AppendNumbers(*fields, &lines.back().text);
    } else if (fields->event() == Event::kNumbers) {
      num_bytes_left_out_ += static_cast<int64_t>(fields->numbers().size());
    } else if (fields->event() == Event::kText) {
      lines.back().text.append(",").append(CsvField(fields->text()));
    }
    const bool ends_line = fields->is_element() && fields->event() != Event::kBeginStruct;
    if (!ends_line) continue;
    std::string columns;
    if (fields->event() == Event::kText) {
      columns = ",value";
    } else {
      AppendColumns(*fields->field().nested, "", &columns);
    }
    Result<void> done = Commit(name, lines.back(), keys, columns);
    if (!done) return done;
    lines.pop_back();
    keys.pop_back();
  }
  return Commit(name, lines.back(), {}, head);
}

Result<void> CsvExporter::Commit(const std::string& name,
                                 const Line& line,
                                 const std::vector<std::string>& keys,
                                 const std::string& columns) {
  const std::string file = name + (line.table.empty() ? "" : "." + line.table) + ".csv";
  if (tables_.size() >= kMostTables && !tables_.contains(file)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("more than %zu tables, expected fewer channels; choose with --channels",
                        kMostTables)};
  }
  Table& table = tables_[file];
  if (table.file.empty()) {
    table.file = folder_->path() / file;
    for (const std::string& key : keys) {
      table.waiting += (table.waiting.empty() ? "" : ",") + key;
    }
    table.waiting += columns + "\n";
  }
  ++table.num_rows;
  table.waiting += line.text;
  table.waiting += '\n';
  if (table.waiting.size() < kFlushBytes) return {};
  return Flush(&table);
}

void CsvExporter::AppendNumbers(const MessageFields& fields, std::string* text) {
  const FieldNumbers& numbers = fields.numbers();
  const bool in_a_cell = fields.field().count_from >= 0;
  if (in_a_cell) *text += ',';
  if (in_a_cell && numbers.size() > kMostInACell) {
    ++num_long_lists_;
    return;
  }
  for (size_t i = 0; i < numbers.size(); ++i) {
    if (!in_a_cell || i > 0) *text += in_a_cell ? ' ' : ',';
    *text += numbers.Text(i);
  }
}

Result<void> CsvExporter::Flush(Table* table) {
  Result<void> appended = AppendToFile(table->file, table->waiting);
  table->waiting.clear();
  return appended;
}

Result<std::string> CsvExporter::Finish() {
  if (tables_.empty()) {
    return Error{ErrorCode::kNotFound, "no messages of a known type to export"};
  }
  std::string text;
  for (auto& [name, table] : tables_) {
    if (Result<void> flushed = Flush(&table); !flushed) return flushed.error();
    text += Format("%-44s %9jd lines\n", name.c_str(), intmax_t{table.num_rows});
  }
  if (num_bytes_left_out_ > 0) {
    text += Format("left out: %jd bytes of images and the like\n", intmax_t{num_bytes_left_out_});
  }
  if (num_long_lists_ > 0) {
    text += Format("left out: %jd lists of more than %zu numbers, whose cells are empty\n",
                   intmax_t{num_long_lists_},
                   kMostInACell);
  }
  for (const auto& [channel, count] : foreign_) {
    text += Format("left out: %jd messages of an unknown type on %s\n",
                   intmax_t{count},
                   FileNameOf(channel).c_str());
  }
  if (num_malformed_ > 0) {
    text += Format("left out: %jd malformed messages\n", intmax_t{num_malformed_});
  }
  if (Result<void> published = folder_->Publish(); !published) return published.error();
  return text;
}

}  // namespace

Result<std::unique_ptr<LogExporter>> MakeCsvExporter(const fs::path& folder) {
  Result<std::unique_ptr<ExportFolder>> made = ExportFolder::Create(folder);
  if (!made) return made.error();
  return std::unique_ptr<LogExporter>(new CsvExporter(std::move(made).value()));
}

}  // namespace vantage
