#include <map>
#include <system_error>
#include <utility>

#include "bus/message_fields.h"
#include "bus/wire.h"
#include "common/format.h"
#include "common/time_range.h"
#include "tools/log/foxglove_messages.h"
#include "tools/log/log_exporter.h"
#include "tools/log/mcap_writer.h"
#include "tools/log/message_json.h"
#include "tools/log/shown_text.h"
#include "vantage/images_t.hpp"
#include "vantage/rigid_transform_t.hpp"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr const char* kJson = "json";
constexpr const char* kLcm = "x-lcm";
constexpr uint64_t kNanoseconds = 1000;  // in a us
constexpr size_t kMostTopics = 5000;     // Names of channels come from outside.

uint64_t Nanoseconds(int64_t utime) {
  return IsPlausibleUtime(utime) ? kNanoseconds * static_cast<uint64_t>(utime) : 0;
}

class McapExporter : public LogExporter {
 public:
  explicit McapExporter(std::unique_ptr<McapWriter> writer) : writer_(std::move(writer)) {}

  Result<void> Add(const LogEventView& event, bool wanted) override;
  Result<std::string> Finish() override;

 private:
  struct Topic {
    uint16_t channel = 0;
    std::string schema;
    int64_t num_messages = 0;
  };

  Result<void> AddOurs(const LogEventView& event,
                       const MessageSchema& schema,
                       MessageFields fields);
  Result<void> Put(const std::string& topic,
                   const std::string& schema,
                   const char* encoding,
                   const LogEventView& event,
                   uint64_t publish_time,
                   std::string_view data);
  uint16_t SchemaNumber(const std::string& name);

  std::unique_ptr<McapWriter> writer_;
  std::map<std::string, uint16_t> schemas_;
  std::map<std::string, Topic> topics_;  // By name, and by schema where several share it.
  int64_t num_malformed_ = 0;
  int64_t num_without_time_ = 0;
  std::string first_malformed_;
};

Result<void> McapExporter::Add(const LogEventView& event, bool wanted) {
  if (!wanted) return {};
  if (!IsPlausibleUtime(event.utime)) ++num_without_time_;
  const bool has_type = event.data.size() >= sizeof(int64_t);
  const MessageSchema* schema = has_type ? FindSchema(LoadBigEndian<int64_t>(event.data)) : nullptr;
  if (schema == nullptr) {
    const std::string_view bytes(reinterpret_cast<const char*>(event.data.data()),
                                 event.data.size());
    const std::string topic = Format("/%s", Printable(event.channel).c_str());
    return Put(topic, "", kLcm, event, Nanoseconds(event.utime), bytes);
  }
  Result<MessageFields> fields = MessageFields::Open(event.data);
  if (!fields) {
    if (num_malformed_++ == 0) first_malformed_ = fields.error().message;
    return {};
  }
  return AddOurs(event, *schema, std::move(fields).value());
}

Result<void> McapExporter::AddOurs(const LogEventView& event,
                                   const MessageSchema& schema,
                                   MessageFields fields) {
  uint64_t publish_time = Nanoseconds(event.utime);
  if (!schema.fields.empty() && schema.fields.front().name == "utime") {
    const auto utime = LoadBigEndian<int64_t>(event.data.subspan(sizeof(int64_t)));
    if (IsPlausibleUtime(utime)) publish_time = Nanoseconds(utime);
  }
  const Result<std::vector<FoxgloveMessage>> drawn = FoxgloveMessages(event);
  if (!drawn && num_malformed_++ == 0) first_malformed_ = drawn.error().message;
  if (drawn) {
    for (const FoxgloveMessage& each : *drawn) {
      const std::string text = JsonText(each.content);
      Result<void> put = Put(each.topic, each.schema, kJson, event, publish_time, text);
      if (!put) return put;
    }
  }
  // Of these nothing is left that the above does not say.
  const bool is_bulk = schema.name == images_t::getTypeName();
  if (is_bulk || (schema.name == rigid_transform_t::getTypeName() && drawn && !drawn->empty())) {
    return {};
  }
  const std::string text = JsonText(JsonFromMessage(std::move(fields)));
  const std::string topic = Format("/%s", Printable(event.channel).c_str());
  return Put(topic, "vantage." + std::string(schema.name), kJson, event, publish_time, text);
}

Result<void> McapExporter::Put(const std::string& topic,
                               const std::string& schema,
                               const char* encoding,
                               const LogEventView& event,
                               uint64_t publish_time,
                               std::string_view data) {
  std::string key = topic;
  key += '\0';
  key += schema;
  auto found = topics_.find(key);
  if (found == topics_.end()) {
    if (topics_.size() >= kMostTopics) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("more than %zu topics, expected fewer channels; choose with --channels",
                          kMostTopics)};
    }
    const uint16_t channel = writer_->AddChannel(topic, encoding, SchemaNumber(schema));
    found =
        topics_.emplace(key, Topic{.channel = channel, .schema = schema, .num_messages = 0}).first;
  }
  ++found->second.num_messages;
  return writer_->Write(found->second.channel, Nanoseconds(event.utime), publish_time, data);
}

uint16_t McapExporter::SchemaNumber(const std::string& name) {
  constexpr std::string_view kOurs = "vantage.";
  if (name.empty()) return 0;
  uint16_t& number = schemas_[name];
  if (number != 0) return number;
  const nlohmann::ordered_json schema =
      name.starts_with(kOurs)
          ? JsonSchemaOf(*FindSchema(std::string_view(name).substr(kOurs.size())))
          : FoxgloveSchema(name);
  number = writer_->AddSchema(name, JsonText(schema));
  return number;
}

Result<std::string> McapExporter::Finish() {
  if (topics_.empty()) return Error{ErrorCode::kNotFound, "no messages to export"};
  if (Result<void> closed = writer_->Close(); !closed) return closed.error();
  std::string text;
  for (const auto& [key, topic] : topics_) {
    text += Format("%-36s %-34s %9jd\n",
                   key.c_str(),
                   topic.schema.empty() ? "(foreign type, raw bytes)" : topic.schema.c_str(),
                   intmax_t{topic.num_messages});
  }
  if (num_malformed_ > 0) {
    text += Format("left out: %jd malformed messages, the first: %s\n",
                   intmax_t{num_malformed_},
                   first_malformed_.c_str());
  }
  if (num_without_time_ > 0) {
    text += Format("%jd messages have no time of 1970 to 2200 and got the first of it\n",
                   intmax_t{num_without_time_});
  }
  return text;
}

}  // namespace

Result<std::unique_ptr<LogExporter>> MakeMcapExporter(const fs::path& file) {
  std::error_code error;
  if (fs::exists(file, error)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("output %s exists, expected a new name", file.c_str())};
  }
  Result<std::unique_ptr<McapWriter>> writer = McapWriter::Create(file);
  if (!writer) return writer.error();
  return std::unique_ptr<LogExporter>(new McapExporter(std::move(writer).value()));
}

}  // namespace vantage
