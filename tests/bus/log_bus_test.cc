#include "bus/log_bus.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "bus/log_bus_port.h"
#include "bus/message_schema.h"
#include "tests/bus/support/temporary_folder.h"
#include "vantage/next_view_t.hpp"
#include "vantage/rigid_transform_t.hpp"

namespace vantage {
namespace {

namespace fs = std::filesystem;

next_view_t NextView(int64_t seq) {
  next_view_t message{};
  message.seq = seq;
  return message;
}

struct LogBusTest : testing::Test {
  struct Recorded {
    int64_t utime;
    std::string channel;
    int64_t seq;
  };

  void WriteInput(const std::vector<Recorded>& events) {
    auto writer = EventLogWriter::Create(input);
    ASSERT_TRUE(writer.ok());
    for (const Recorded& event : events) {
      ASSERT_TRUE((*writer)->Write(event.utime, event.channel, Encode(NextView(event.seq))).ok());
    }
    ASSERT_TRUE((*writer)->Close().ok());
  }

  std::unique_ptr<LogBus> Open(const LogBus::Options& options = {},
                               EventLogWriter* writer = nullptr) {
    auto reader = EventLogReader::Open(input);
    EXPECT_TRUE(reader.ok()) << reader.error().message;
    auto bus = LogBus::Create(options, std::move(reader).value(), writer);
    EXPECT_TRUE(bus.ok()) << bus.error().message;
    return std::move(bus).value();
  }

  static std::string Load(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  TemporaryFolder folder;
  fs::path input = folder.path() / "in.log";
  std::vector<std::string> seen;  // "CHANNEL seq @utime"
};

// Notes every message, and answers A with B, and B with C.
void AddChain(LogBus& bus, std::vector<std::string>* seen) {
  const auto note = [&bus, seen](const Envelope& envelope, const next_view_t& message) {
    EXPECT_EQ(envelope.receive_utime, bus.NowUtime());
    seen->push_back(envelope.channel + " " + std::to_string(message.seq) + " @" +
                    std::to_string(bus.NowUtime()));
    const std::string next = envelope.channel == "A" ? "B" : envelope.channel == "B" ? "C" : "";
    if (next.empty()) return;
    EXPECT_TRUE(bus.Publish(next, NextView(message.seq)).ok());
    EXPECT_TRUE(bus.Publish(next, NextView(message.seq + 1)).ok());
  };
  ASSERT_TRUE(bus.Subscribe<next_view_t>("[ABC]", {}, note).ok());
}

TEST_F(LogBusTest, DeliversAnswersInTurnBeforeTheNextEvent) {
  WriteInput({{100, "A", 10}, {200, "A", 20}});
  auto bus = Open();
  AddChain(*bus, &seen);
  EXPECT_EQ(bus->NowUtime(), 100);
  ASSERT_TRUE(bus->Run().ok());
  EXPECT_EQ(seen,
            (std::vector<std::string>{"A 10 @100",
                                      "B 10 @100",
                                      "B 11 @100",
                                      "C 10 @100",
                                      "C 11 @100",
                                      "C 11 @100",
                                      "C 12 @100",
                                      "A 20 @200",
                                      "B 20 @200",
                                      "B 21 @200",
                                      "C 20 @200",
                                      "C 21 @200",
                                      "C 21 @200",
                                      "C 22 @200"}));
  EXPECT_EQ(bus->counters().num_events, 2);
  EXPECT_EQ(bus->counters().num_published, 12);
  EXPECT_EQ(bus->counters().num_delivered, 14);
}

TEST_F(LogBusTest, OutputIsTheSameEveryTime) {
  WriteInput({{100, "A", 10}, {200, "X", 1}, {200, "A", 20}, {150, "A", 30}});
  std::vector<std::string> outputs;
  for (const char* name : {"out1.log", "out2.log"}) {
    auto writer = EventLogWriter::Create(folder.path() / name);
    ASSERT_TRUE(writer.ok());
    LogBus::Options options;
    options.header.version = "1.2.3";
    options.header.config_text = "k = 1";
    options.header.seed = 5;
    auto bus = Open(options, writer->get());
    AddChain(*bus, &seen);
    ASSERT_TRUE(bus->Run().ok());
    ASSERT_TRUE((*writer)->Close().ok());
    outputs.push_back(Load(folder.path() / name));
  }
  EXPECT_GT(outputs[0].size(), 1000U);
  EXPECT_EQ(outputs[0], outputs[1]);

  auto reader = EventLogReader::Open(folder.path() / "out1.log");
  ASSERT_TRUE(reader.ok());
  const std::optional<LogEvent> first = (*reader)->Next();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->channel, "LOG_HEADER");
  EXPECT_EQ(first->utime, 100);
  const Result<log_header_t> header = DecodeChecked<log_header_t>(first->data);
  ASSERT_TRUE(header.ok()) << header.error().message;
  EXPECT_EQ(header.value().version, "1.2.3");
  EXPECT_EQ(header.value().config_text, "k = 1");
  EXPECT_EQ(header.value().seed, 5);
  EXPECT_EQ(header.value().schema_names.size(), AllSchemas().size());
  std::vector<int64_t> utimes;
  while (const std::optional<LogEvent> event = (*reader)->Next()) utimes.push_back(event->utime);
  EXPECT_EQ(utimes,
            (std::vector<int64_t>{100,
                                  100,
                                  100,
                                  100,
                                  100,
                                  100,
                                  200,
                                  200,
                                  200,
                                  200,
                                  200,
                                  200,
                                  150,
                                  150,
                                  150,
                                  150,
                                  150,
                                  150}));
}

TEST_F(LogBusTest, SuppressesWhatIsComputedAnew) {
  WriteInput({{100, "A", 10}, {100, "B", 1000}, {100, "C", 2000}, {200, "A", 20}});
  LogBus::Options options;
  options.suppress = "B|C";
  auto bus = Open(options);
  AddChain(*bus, &seen);
  ASSERT_TRUE(bus->Run().ok());
  EXPECT_EQ(seen.size(), 14U);
  for (const std::string& each : seen) EXPECT_EQ(each.find("000 @"), std::string::npos) << each;
  EXPECT_EQ(bus->counters().num_events, 4);
  EXPECT_EQ(bus->counters().num_suppressed, 2);
}

TEST_F(LogBusTest, DeliversWhatWasPublishedBeforeTheFirstEvent) {
  WriteInput({{100, "A", 10}});
  auto bus = Open();
  AddChain(*bus, &seen);
  ASSERT_TRUE(bus->Publish("C", NextView(1)).ok());
  ASSERT_TRUE(bus->Run().ok());
  ASSERT_GE(seen.size(), 2U);
  EXPECT_EQ(seen[0], "C 1 @100");
  EXPECT_EQ(seen[1], "A 10 @100");
}

TEST_F(LogBusTest, CountsWhatCannotBeDecodedAndWhatIsMissing) {
  auto writer = EventLogWriter::Create(input);
  ASSERT_TRUE(writer.ok());
  ASSERT_TRUE((*writer)->Write(1, "A", Encode(NextView(1))).ok());
  ASSERT_TRUE((*writer)->Write(2, "A", std::vector<std::byte>(50)).ok());
  ASSERT_TRUE((*writer)->Write(3, "A", Encode(NextView(4))).ok());
  ASSERT_TRUE((*writer)->Write(4, "A", Encode(NextView(0))).ok());  // Started anew.
  ASSERT_TRUE((*writer)->Close().ok());
  auto bus = Open();
  int count = 0;
  const auto handler = [&](const Envelope&, const next_view_t&) { ++count; };
  // Live this would keep one message; over a log nothing is let go.
  ASSERT_TRUE(bus->Subscribe<next_view_t>("A", {SubscribeOptions::Keep::kLatest}, handler).ok());
  ASSERT_TRUE(bus->Run().ok());
  EXPECT_EQ(count, 3);
  EXPECT_EQ(bus->counters().num_delivered, 3);
  EXPECT_EQ(bus->counters().decode_errors.at("A"), 1);
  EXPECT_EQ(bus->counters().num_lost, 2);
  EXPECT_NE(bus->counters().first_decode_error.find("A: next_view_t: fingerprint"),
            std::string::npos);
}

TEST_F(LogBusTest, EndsWhenHandlersAnswerEachOtherForEver) {
  WriteInput({{100, "A", 10}});
  auto bus = Open();
  const auto handler = [&](const Envelope&, const next_view_t& message) {
    EXPECT_TRUE(bus->Publish("A", message).ok());
  };
  ASSERT_TRUE(bus->Subscribe<next_view_t>("A", {}, handler).ok());
  const Result<void> run = bus->Run();
  ASSERT_FALSE(run.ok());
  EXPECT_NE(run.error().message.find("without end"), std::string::npos);
}

TEST_F(LogBusTest, PortsGetHeldChannelsWhenSomebodySaysSo) {
  WriteInput({{100, "A", 1}, {200, "B", 2}, {300, "A", 3}, {400, "GO", 0}});
  LogBus::Options options;
  options.suppress = "GO";
  auto bus = Open(options);
  const Result<LogBus::Port*> port = bus->AddPort("A");
  ASSERT_TRUE(port.ok());
  std::optional<LogEvent> held;
  bus->Watch([&](const LogEvent& event) {
    seen.push_back("watched " + event.channel);
    if (event.channel == "A" && !held) held = event;
    if (event.channel == "GO") (*port)->Deliver(*held);
  });
  const auto note = [&](const std::string& who) {
    return [&, who](const Envelope& envelope, const next_view_t& message) {
      seen.push_back(who + " " + envelope.channel + std::to_string(message.seq) + " @" +
                     std::to_string(bus->NowUtime()));
      if (who == "port" && envelope.channel == "A") {
        EXPECT_TRUE((*port)->Publish("C", message).ok());
      }
    };
  };
  ASSERT_TRUE((*port)->Subscribe<next_view_t>("A|B|C", {}, note("port")).ok());
  ASSERT_TRUE(bus->Subscribe<next_view_t>("A|C", {}, note("bus")).ok());
  ASSERT_TRUE(bus->Run().ok());
  EXPECT_EQ(seen,
            (std::vector<std::string>{"watched A",
                                      "bus A1 @100",
                                      "watched B",
                                      "port B2 @200",
                                      "watched A",
                                      "bus A3 @300",
                                      "watched GO",
                                      "port A1 @400",
                                      "port C1 @400",
                                      "bus C1 @400"}));
}

TEST_F(LogBusTest, RefusesBadPatterns) {
  WriteInput({{100, "A", 10}});
  auto reader = EventLogReader::Open(input);
  ASSERT_TRUE(reader.ok());
  LogBus::Options options;
  options.suppress = "A(";
  EXPECT_FALSE(LogBus::Create(options, std::move(reader).value(), nullptr).ok());
  EXPECT_FALSE(Open()->AddPort("A(").ok());
}

}  // namespace
}  // namespace vantage
