#include "bus/live_bus.h"

#include <arpa/inet.h>
#include <lcm/lcm.h>
#include <poll.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "bus/channel_pattern.h"
#include "bus/lcm_url.h"
#include "bus/mailbox.h"
#include "bus/message_schema.h"
#include "bus/process_status.h"
#include "bus/receive_buffer.h"
#include "bus/wire.h"
#include "common/format.h"

namespace vantage {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kStatusInterval(1);
// Messages that LCM may hold for a subscription until our thread copies them; its own 30 are too
// few for a burst while the machine stalls.
constexpr int kLcmQueue = 256;
constexpr const char* kAddRoute = "ip link set lo up; ip route add 224.0.0.0/4 dev lo";

int64_t WallClockUtime() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

spdlog::logger& Log() {
  static spdlog::logger logger("bus", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
  return logger;
}

std::string HostName() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

Error NoRoute(const LcmUrl& url, const std::string& why) {
  return {ErrorCode::kUnavailable,
          Format("no multicast route to %s (%s), expected one; for one machine alone run: %s",
                 url.Place().c_str(),
                 why.c_str(),
                 kAddRoute)};
}

// LCM only prints a page of advice when the route is missing, so it is looked for before.
Result<void> CheckRoute(const LcmUrl& url) {
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return Error{ErrorCode::kIo, Format("no UDP socket: %s", std::strerror(errno))};
  sockaddr_in group{};
  group.sin_family = AF_INET;
  group.sin_port = htons(url.port);
  inet_pton(AF_INET, url.address.c_str(), &group.sin_addr);
  const int status = connect(probe, reinterpret_cast<const sockaddr*>(&group), sizeof group);
  const int error = errno;
  close(probe);
  if (status != 0) return NoRoute(url, std::strerror(error));
  return {};
}

Result<int> GrantBuffer(const LcmUrl& url, int requested, int at_least) {
  if (url.provider == LcmUrl::Provider::kMemory) return requested;
  const int granted = GrowReceiveBuffers(url.port, requested);
  if (granted >= at_least) return granted;
  return Error{
      ErrorCode::kUnavailable,
      Format("the kernel grants a receive buffer of %d bytes on %s, expected at least %d of the %d "
             "asked for; run: sysctl -w net.core.rmem_max=%d",
             granted,
             url.Place().c_str(),
             at_least,
             requested,
             requested)};
}

}  // namespace

struct LiveBus::Impl {
  struct Subscription {
    Impl* impl;
    size_t index;
    std::optional<int64_t> fingerprint;  // Nothing: any type, unchecked.
    BytesHandler handler;
  };

  explicit Impl(LiveBus::Options the_options, LcmUrl the_url)
      : options(std::move(the_options)), url(std::move(the_url)) {}
  ~Impl() {
    status_thread.request_stop();
    receive_thread.request_stop();
    if (wake >= 0) eventfd_write(wake, 1);
    if (status_thread.joinable()) status_thread.join();
    if (receive_thread.joinable()) receive_thread.join();
    if (lcm != nullptr) lcm_destroy(lcm);
    if (wake >= 0) close(wake);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // On the receive thread, through lcm_handle(): nothing may be thrown.
  static void OnMessage(const lcm_recv_buf_t* buffer, const char* channel, void* user) noexcept {
    const auto& subscription = *static_cast<const Subscription*>(user);
    Impl& impl = *subscription.impl;
    try {
      const auto* data = static_cast<const std::byte*>(buffer->data);
      impl.Receive(subscription, channel, buffer->recv_utime, {data, buffer->data_size});
    } catch (const std::exception& exception) {
      Log().error("a message on {} was dropped: {}", channel, exception.what());
    }
  }

  void Receive(const Subscription& subscription,
               const std::string& channel,
               int64_t utime,
               std::span<const std::byte> bytes) {
    status.RecordReceived(channel, Clock::now());
    // What is clearly another type must not push a good message out of its slot.
    if (subscription.fingerprint &&
        (bytes.size() < 8 || LoadBigEndian<int64_t>(bytes) != *subscription.fingerprint)) {
      ReportDecodeError(subscription, channel, bytes);
      return;
    }
    for (const std::string& skipped : mailbox.Put(subscription.index, channel, utime, bytes)) {
      status.RecordOverwritten(skipped);
    }
  }

  void ReportDecodeError(const Subscription& subscription,
                         const std::string& channel,
                         std::span<const std::byte> bytes) {
    if (!status.RecordDecodeError(channel, Clock::now())) return;
    const MessageSchema* schema =
        subscription.fingerprint ? FindSchema(*subscription.fingerprint) : nullptr;
    const Result<void> check =
        CheckMessageBytes(schema == nullptr ? "" : std::string(schema->name), bytes);
    Log().warn("{}: message dropped: {}",
               channel,
               check ? "its content can't be decoded" : check.error().message);
  }

  // On the owner's thread.
  void Handle(const Mailbox::Item& item) {
    Subscription& subscription = *subscriptions[item.subscription];
    if (!subscription.handler(item.envelope, item.bytes)) {
      ReportDecodeError(subscription, item.envelope.channel, item.bytes);
    }
  }

  void ReceiveLoop(const std::stop_token& stop) {
    std::array<pollfd, 2> files = {
        pollfd{.fd = lcm_get_fileno(lcm), .events = POLLIN, .revents = 0},
        pollfd{.fd = wake, .events = POLLIN, .revents = 0}};
    while (!stop.stop_requested()) {
      if (poll(files.data(), files.size(), -1) < 0 || (files[0].revents & POLLIN) == 0) continue;
      if (lcm_handle(lcm) == 0) continue;
      Log().error("LCM can't receive on {}: {}", url.Place(), std::strerror(errno));
      poll(&files[1], 1, 1000);
    }
  }

  void StatusLoop(const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any never;
    std::unique_lock lock(mutex);
    auto next = Clock::now();
    while (!stop.stop_requested()) {
      const std::vector<std::byte> bytes = Encode(MakeStatus(status_seq++));
      lcm_publish(lcm, "PROCESS_STATUS", bytes.data(), static_cast<unsigned>(bytes.size()));
      next = std::max(next + kStatusInterval, Clock::now());
      never.wait_until(lock, stop, next, [] { return false; });
    }
  }

  process_status_t MakeStatus(int64_t seq) {
    process_status_t message{};
    message.utime = WallClockUtime();
    message.seq = seq;
    message.name = options.name;
    message.host = host;
    message.pid = getpid();
    message.version = options.version;
    message.config_hash = options.config_hash;
    message.start_utime = start_utime;
    message.receive_buffer_requested = options.receive_buffer_bytes;
    message.receive_buffer_granted = granted;
    status.Fill(Clock::now(), &message);
    return message;
  }

  LiveBus::Options options;
  LcmUrl url;
  lcm_t* lcm = nullptr;
  int wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  int granted = 0;
  std::string host = HostName();
  int64_t start_utime = WallClockUtime();
  std::atomic<int64_t> status_seq = 0;
  ProcessStatus status;
  Mailbox mailbox;
  std::vector<std::unique_ptr<Subscription>> subscriptions;  // Of the owner's thread.
  std::jthread receive_thread;
  std::jthread status_thread;
};

Result<void> LiveBus::Options::Validate() const {
  if (name.empty() || name.size() > 64) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("process name is '%s', expected 1 to 64 characters", name.c_str())};
  }
  constexpr int kLargest = 1 << 30;
  if (min_receive_buffer_bytes < 0 || receive_buffer_bytes < min_receive_buffer_bytes ||
      receive_buffer_bytes > kLargest) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("receive_buffer_bytes is %d, expected %d (min_receive_buffer_bytes) to %d",
                        receive_buffer_bytes,
                        min_receive_buffer_bytes,
                        kLargest)};
  }
  return {};
}

Result<std::unique_ptr<LiveBus>> LiveBus::Create(const Options& options) {
  if (Result<void> valid = options.Validate(); !valid) return valid.error();
  Result<LcmUrl> url = LcmUrl::ParseOrDefault(options.url);
  if (!url) return url.error();
  const std::string buffer = url->Option("recv_buf_size");
  if (!buffer.empty() && std::stoi(buffer) < options.min_receive_buffer_bytes) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("recv_buf_size of LCM URL '%s' is %s, expected at least %d "
                        "(min_receive_buffer_bytes)",
                        url->Text().c_str(),
                        buffer.c_str(),
                        options.min_receive_buffer_bytes)};
  }
  if (url->provider == LcmUrl::Provider::kUdpMulticast) {
    url->SetDefault("ttl", "0");
    url->SetDefault("recv_buf_size", std::to_string(options.receive_buffer_bytes));
    if (Result<void> route = CheckRoute(*url); !route) return route.error();
  }
  auto impl = std::make_unique<Impl>(options, *url);
  if (impl->wake < 0) {
    return Error{ErrorCode::kIo, Format("no eventfd: %s", std::strerror(errno))};
  }
  // Not told of the buffer that is wanted, over which it would print a page: it is set below.
  LcmUrl plain = *url;
  std::erase_if(plain.options, [](const auto& option) { return option.first == "recv_buf_size"; });
  impl->lcm = lcm_create(plain.Text().c_str());
  if (impl->lcm == nullptr) return NoRoute(*url, "LCM refuses it");
  // LCM opens its receiving sockets, and tries whether they hear, when first asked for this.
  if (lcm_get_fileno(impl->lcm) < 0) return NoRoute(*url, "LCM does not hear its own messages");
  if (!buffer.empty()) impl->options.receive_buffer_bytes = std::stoi(buffer);
  Result<int> granted =
      GrantBuffer(*url, impl->options.receive_buffer_bytes, options.min_receive_buffer_bytes);
  if (!granted) return granted.error();
  impl->granted = *granted;

  Impl* raw = impl.get();
  impl->receive_thread =
      std::jthread([raw](const std::stop_token& stop) { raw->ReceiveLoop(stop); });
  impl->status_thread = std::jthread([raw](const std::stop_token& stop) { raw->StatusLoop(stop); });
  return std::unique_ptr<LiveBus>(new LiveBus(std::move(impl)));
}

LiveBus::LiveBus(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LiveBus::~LiveBus() = default;

bool LiveBus::Dispatch(std::chrono::milliseconds timeout) {
  std::optional<Mailbox::Item> item = impl_->mailbox.Take(Clock::now() + timeout);
  if (!item) return false;
  impl_->Handle(*item);
  return true;
}

void LiveBus::Run(const std::stop_token& stop,
                  const std::function<void()>& poll,
                  std::chrono::milliseconds poll_interval) {
  auto next_poll = Clock::now();
  while (!stop.stop_requested()) {
    if (const auto now = Clock::now(); now >= next_poll) {
      if (poll) poll();
      next_poll = now + poll_interval;
    }
    std::optional<Mailbox::Item> item = impl_->mailbox.Take(next_poll, stop);
    if (item && !stop.stop_requested()) impl_->Handle(*item);
  }
}

void LiveBus::RecordStage(const std::string& stage, double seconds) {
  impl_->status.RecordStage(stage, seconds);
}

void LiveBus::RecordLost(const std::string& channel, int64_t count) {
  impl_->status.RecordLost(channel, count);
}

void LiveBus::SetState(const std::string& state) { impl_->status.SetState(state); }

int64_t LiveBus::NowUtime() const { return WallClockUtime(); }

process_status_t LiveBus::Status() { return impl_->MakeStatus(impl_->status_seq); }

std::string LiveBus::url() const { return impl_->url.Text(); }

Result<void> LiveBus::Tap(const std::string& channel,
                          SubscribeOptions options,
                          TapHandler handler) {
  return AddSubscription(
      channel,
      std::nullopt,
      options,
      [handler = std::move(handler)](const Envelope& envelope, std::span<const std::byte> bytes) {
        handler(envelope, bytes);
        return true;
      });
}

Result<void> LiveBus::SubscribeBytes(const std::string& channel,
                                     int64_t fingerprint,
                                     SubscribeOptions options,
                                     BytesHandler handler) {
  return AddSubscription(channel, fingerprint, options, std::move(handler));
}

Result<void> LiveBus::AddSubscription(const std::string& channel,
                                      std::optional<int64_t> fingerprint,
                                      SubscribeOptions options,
                                      BytesHandler handler) {
  Result<ChannelPattern> pattern = ChannelPattern::Create(channel);
  if (!pattern) return pattern.error();
  if (pattern->IsName()) impl_->status.AddChannel(channel);
  impl_->subscriptions.push_back(std::make_unique<Impl::Subscription>(
      Impl::Subscription{.impl = impl_.get(),
                         .index = impl_->mailbox.AddSubscription(options),
                         .fingerprint = fingerprint,
                         .handler = std::move(handler)}));
  lcm_subscription_t* subscription = lcm_subscribe(
      impl_->lcm, channel.c_str(), &Impl::OnMessage, impl_->subscriptions.back().get());
  if (subscription == nullptr) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("LCM refuses the channel '%s', expected a name or a regular expression",
                        channel.c_str())};
  }
  lcm_subscription_set_queue_capacity(subscription, kLcmQueue);
  return {};
}

Result<void> LiveBus::PublishBytes(const std::string& channel, std::span<const std::byte> bytes) {
  if (channel.empty() || channel.size() > kMaxChannelName) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("channel '%s' can't be sent on, expected a name of 1 to %zu characters",
                        channel.c_str(),
                        kMaxChannelName)};
  }
  errno = 0;
  if (lcm_publish(impl_->lcm, channel.c_str(), bytes.data(), static_cast<unsigned>(bytes.size())) !=
      0) {
    return Error{ErrorCode::kIo,
                 Format("%zu bytes can't be sent on %s over %s: %s",
                        bytes.size(),
                        channel.c_str(),
                        impl_->url.Place().c_str(),
                        std::strerror(errno))};
  }
  return {};
}

}  // namespace vantage
