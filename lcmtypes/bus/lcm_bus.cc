#include "lcmtypes/bus/lcm_bus.h"

#include <fmt/format.h>
#include <lcm/lcm.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <string_view>
#include <utility>

#include "base/check.h"
#include "lcmtypes/bus/datagram_guard.h"
#include "lcmtypes/bus/limits.h"
#include "lcmtypes/channels.h"

namespace muster {
namespace {

using Clock = std::chrono::steady_clock;

/// A burst longer than this is handed out in parts, so that a flood cannot hold Receive forever.
constexpr int kMaxBurst = 10000;

/// Threads that are started within its life take no signals: they stay with the caller's thread,
/// whose waiting they must end.
class BlockSignals {
 public:
  BlockSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~BlockSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockSignals(const BlockSignals&) = delete;
  BlockSignals& operator=(const BlockSignals&) = delete;

 private:
  sigset_t before_;
};

struct RoundTrip {
  std::string content;
  bool done = false;
};

void OnRoundTrip(const lcm_recv_buf_t* message, const char* /*channel*/, void* user) {
  auto* trip = static_cast<RoundTrip*>(user);
  const std::string_view got(static_cast<const char*>(message->data), message->data_size);
  if (got == trip->content) trip->done = true;
}

}  // namespace

std::string LcmVersion() {
  return fmt::format("{}.{}.{}", LCM_MAJOR_VERSION, LCM_MINOR_VERSION, LCM_MICRO_VERSION);
}

void LcmBus::Destroy::operator()(_lcm_t* lcm) const { lcm_destroy(lcm); }

LcmBus::LcmBus(const std::string& url) : url_(url) {
  const MulticastUrl parts = ParseMulticastUrl(url);
  // LCM's own self-test speaks to stderr only and may abort: what it needs is looked at first.
  if (const auto problem = MulticastProblem(parts.address)) {
    throw SystemError(fmt::format(
        "no multicast on this host: {}; start the mission with 'muster run', which makes a private "
        "network, or {}",
        *problem, kMulticastAdvice));
  }

  const BlockSignals block;
  lcm_.reset(lcm_create(url.c_str()));
  if (lcm_ == nullptr) throw SystemError(fmt::format("LCM cannot open {}", url));
  fd_ = lcm_get_fileno(lcm_.get());
  if (fd_ < 0) {
    throw SystemError(fmt::format(
        "LCM cannot receive on {}: see its message above; 'muster doctor' tells more", url));
  }
  // LCM tells no socket before it reads from it: unguarded is its self-test, a millisecond or two.
  for (const int socket : SocketsOnPort(parts.port)) {
    if (const auto problem = GuardSocket(socket, GuardedChannels::kOurs)) {
      fmt::print(stderr, "muster: LCM reads datagrams that nothing has checked: {}\n", *problem);
    }
  }
  CheckRoundTrip();
  lcm_subscription_t* subscription = lcm_subscribe(lcm_.get(), "MUSTER_.*", &OnMessage, this);
  if (subscription == nullptr) throw SystemError(fmt::format("LCM cannot subscribe on {}", url));
  lcm_subscription_set_queue_capacity(subscription, 0);
}

LcmBus::~LcmBus() = default;

void LcmBus::CheckRoundTrip() {
  RoundTrip trip{fmt::format("{} {}", getpid(), Clock::now().time_since_epoch().count())};
  lcm_subscription_t* subscription =
      lcm_subscribe(lcm_.get(), kRoundTripChannel, &OnRoundTrip, &trip);
  if (subscription == nullptr) throw SystemError(fmt::format("LCM cannot subscribe on {}", url_));
  const auto deadline = Clock::now() + std::chrono::seconds(3);
  while (!trip.done && Clock::now() < deadline) {
    if (lcm_publish(lcm_.get(), kRoundTripChannel, trip.content.data(),
                    static_cast<unsigned>(trip.content.size())) != 0) {
      throw SystemError(fmt::format("LCM cannot send on {}: {}", url_, std::strerror(errno)));
    }
    while (!trip.done && Ready(100'000)) HandleOne();
  }
  lcm_unsubscribe(lcm_.get(), subscription);
  if (!trip.done) {
    throw SystemError(fmt::format(
        "LCM hears nothing on {}: what is sent does not come back; 'muster doctor' tells more",
        url_));
  }
}

void LcmBus::Publish(const Packet& packet) {
  RequireAcceptable(packet);
  for (int attempt = 0; attempt < 3; ++attempt) {
    errno = 0;
    if (lcm_publish(lcm_.get(), packet.channel.c_str(), packet.bytes.data(),
                    static_cast<unsigned>(packet.bytes.size())) == 0) {
      ++counters_.published;
      return;
    }
    if (errno != EINTR) break;
  }
  if (errno == ENOBUFS || errno == EAGAIN || errno == EINTR) {
    ++counters_.not_sent;
    return;
  }
  throw SystemError(fmt::format("LCM cannot send {} bytes on {}, {}: {}", packet.bytes.size(),
                                packet.channel, url_, std::strerror(errno)));
}

bool LcmBus::Ready(std::int64_t timeout_us) const {
  pollfd waiting{fd_, POLLIN, 0};
  const std::int64_t wait_us = std::max<std::int64_t>(timeout_us, 0);
  const timespec timeout{wait_us / 1'000'000, (wait_us % 1'000'000) * 1000};
  const int ready = ppoll(&waiting, 1, &timeout, nullptr);
  if (ready >= 0) return ready > 0;
  if (errno == EINTR) return false;
  throw SystemError(fmt::format("cannot wait for messages: {}", std::strerror(errno)));
}

void LcmBus::HandleOne() {
  const int status = lcm_handle(lcm_.get());
  if (callback_error_) std::rethrow_exception(std::exchange(callback_error_, nullptr));
  if (status != 0) throw SystemError(fmt::format("LCM stopped receiving on {}", url_));
}

std::vector<Packet> LcmBus::Receive(std::int64_t timeout_us) {
  // What LCM dispatches may all be rejected: wait on for the rest of the time.
  const auto deadline = Clock::now() + std::chrono::microseconds(timeout_us);
  std::int64_t left_us = timeout_us;
  while (Ready(left_us)) {
    HandleOne();
    for (int i = 1; i < kMaxBurst && Ready(0); ++i) HandleOne();
    if (!inbox_.empty()) break;
    left_us =
        std::chrono::duration_cast<std::chrono::microseconds>(deadline - Clock::now()).count();
    if (left_us <= 0) break;
  }
  counters_.received += static_cast<std::int64_t>(inbox_.size());
  return std::exchange(inbox_, {});
}

void LcmBus::OnMessage(const lcm_recv_buf_t* message, const char* channel, void* bus) noexcept {
  auto* self = static_cast<LcmBus*>(bus);
  try {
    const auto* data = static_cast<const std::uint8_t*>(message->data);
    const Channel* row = FindChannel(channel);
    if (row == nullptr || message->data_size > static_cast<std::uint64_t>(row->max_bytes)) {
      ++self->counters_.rejected;
      return;
    }
    self->inbox_.push_back({channel, {data, data + message->data_size}});
  } catch (...) {
    self->callback_error_ = std::current_exception();
  }
}

}  // namespace muster
