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

constexpr std::int64_t kProbeUs = 20'000;
/// Probes that the kernel took and that did not come back, after which the group is joined anew.
constexpr int kProbesToRejoin = 5;
constexpr std::int64_t kFailingUs = 1'000'000;
/// Of one wait: a process that is stopped meanwhile has not listened.
constexpr std::int64_t kLongestWaitUs = 100'000;

std::int64_t NowUs() {
  return std::chrono::duration_cast<std::chrono::microseconds>(Clock::now().time_since_epoch())
      .count();
}

/// Whether a later packet may go where this one could not.
bool IsOutage(int error) {
  switch (error) {
    case ENETUNREACH:
    case ENETDOWN:
    case ENODEV:
    case ENXIO:
    case EHOSTUNREACH:
    case EHOSTDOWN:
    case EADDRNOTAVAIL:
    case EPERM:  // a firewall
      return true;
    default:
      return false;
  }
}
bool IsFullBuffer(int error) {
  return error == ENOBUFS || error == ENOMEM || error == EAGAIN || error == EINTR;
}

}  // namespace

std::string LcmVersion() {
  return fmt::format("{}.{}.{}", LCM_MAJOR_VERSION, LCM_MINOR_VERSION, LCM_MICRO_VERSION);
}

void LcmBus::Destroy::operator()(_lcm_t* lcm) const { lcm_destroy(lcm); }

LcmBus::LcmBus(const std::string& url, std::size_t tag_bytes, std::optional<LcmTap> tap,
               Reader reader, GuardedChannels channels)
    : url_(url),
      tag_bytes_(tag_bytes),
      parts_(ParseMulticastUrl(url)),
      tap_(std::move(tap)),
      channels_(tap_ ? GuardedChannels::kAny : channels) {
  // LCM's own self-test speaks to stderr only and may abort: what it needs is looked at first.
  if (const auto problem = MulticastProblem(parts_.address)) {
    throw SystemError(fmt::format(
        "no multicast on this host: {}; start the mission with 'muster run', which makes a private "
        "network, or {}",
        *problem, kMulticastAdvice));
  }

  const BlockSignals block;
  lcm_.reset(lcm_create(url.c_str()));
  if (lcm_ == nullptr) throw SystemError(fmt::format("LCM cannot open {}", url));
  if (reader == Reader::kOwnIfItCan) receiver_ = UdpmReceiver::Open(parts_, channels_);
  if (receiver_) {
    fd_ = receiver_->fd();
  } else {
    Subscribe();
  }
  CheckRoundTrip();
}

void LcmBus::Subscribe() {
  fd_ = lcm_get_fileno(lcm_.get());
  if (fd_ < 0) {
    throw SystemError(fmt::format(
        "LCM cannot receive on {}: see its message above; 'muster doctor' tells more", url_));
  }
  // LCM tells no socket before it reads from it: unguarded is its self-test, a millisecond or two.
  for (const int socket : SocketsOnPort(parts_.port)) {
    if (const auto problem = GuardSocket(socket, channels_)) {
      fmt::print(stderr, "muster: LCM reads datagrams that nothing has checked: {}\n", *problem);
    }
  }
  lcm_subscription_t* subscription = lcm_subscribe(lcm_.get(), ".*", &OnLcmMessage, this);
  if (subscription == nullptr) throw SystemError(fmt::format("LCM cannot subscribe on {}", url_));
  lcm_subscription_set_queue_capacity(subscription, 0);
}

LcmBus::~LcmBus() = default;

void LcmBus::CheckRoundTrip() {
  round_trip_ = fmt::format("{} {}", getpid(), Clock::now().time_since_epoch().count());
  const auto send = [this] {
    if (const int error = Send(kRoundTripChannel, round_trip_.data(), round_trip_.size())) {
      throw SystemError(fmt::format("LCM cannot send on {}: {}", url_, std::strerror(error)));
    }
  };
  const auto wait = [this](std::int64_t timeout_us) {
    if (Ready(timeout_us)) Handle();
    return came_back_;
  };
  if (!ComesBack(send, wait, std::chrono::seconds(3))) {
    throw SystemError(fmt::format(
        "LCM hears nothing on {}: what is sent does not come back; 'muster doctor' tells more",
        url_));
  }
}

int LcmBus::Send(const std::string& channel, const void* data, std::size_t size) {
  int error = 0;
  for (int attempt = 0; attempt < 3; ++attempt) {
    errno = 0;
    const int status = lcm_publish(lcm_.get(), channel.c_str(), data, static_cast<unsigned>(size));
    error = errno;
    // Of a message in fragments LCM does not tell that they could not be sent.
    if (status == 0 && !IsOutage(error) && !IsFullBuffer(error)) return 0;
    if (error != EINTR) break;
  }
  return error == 0 ? EIO : error;
}

void LcmBus::Publish(const Packet& packet) {
  RequireAcceptable(packet, tag_bytes_);
  if (!outage_.empty()) {
    ++counters_.not_sent;
    return;
  }
  const int error = Send(packet.channel, packet.bytes.data(), packet.bytes.size());
  if (error == 0) {
    ++counters_.published;
    failing_since_us_ = -1;
    unanswered_ = true;
    return;
  }
  if (!IsOutage(error) && !IsFullBuffer(error)) {
    throw SystemError(fmt::format("LCM cannot send {} bytes on {}, {}: {}", packet.bytes.size(),
                                  packet.channel, url_, std::strerror(error)));
  }
  ++counters_.not_sent;
  NoteFailure(error);
}

void LcmBus::NoteFailure(int error) {
  if (IsOutage(error)) {
    BeginOutage(std::strerror(error));
    return;
  }
  const std::int64_t now_us = NowUs();
  if (failing_since_us_ < 0) failing_since_us_ = now_us;
  if (now_us - failing_since_us_ >= kFailingUs) BeginOutage(std::strerror(error));
}

void LcmBus::BeginOutage(std::string reason) {
  outage_ = std::move(reason);
  outage_since_us_ = probed_us_ = NowUs();
  probes_sent_ = 0;
  came_back_ = false;
}

std::int64_t LcmBus::outage_us() const {
  return past_outages_us_ + (outage_.empty() ? 0 : NowUs() - outage_since_us_);
}

void LcmBus::Probe() {
  const std::int64_t now_us = NowUs();
  if (came_back_) {
    past_outages_us_ += now_us - outage_since_us_;
    outage_.clear();
    failing_since_us_ = -1;
    unanswered_ = false;
    waited_us_ = 0;
    return;
  }
  if (now_us - probed_us_ < kProbeUs) return;
  probed_us_ = now_us;
  if (Send(kRoundTripChannel, round_trip_.data(), round_trip_.size()) != 0) return;
  if (++probes_sent_ % kProbesToRejoin != 0) return;
  for (const int socket : SocketsOnPort(parts_.port)) JoinAgain(socket, parts_.address);
}

void LcmBus::NoteWaited(std::int64_t waited_us) {
  if (!unanswered_ || !outage_.empty()) return;
  const bool asked = waited_us_ >= kFailingUs / 2;
  waited_us_ += std::min(waited_us, kLongestWaitUs);
  // A large message may be lost as it is: a small one shows.
  if (!asked && waited_us_ >= kFailingUs / 2) {
    static_cast<void>(Send(kRoundTripChannel, round_trip_.data(), round_trip_.size()));
  }
  if (waited_us_ >= kFailingUs) BeginOutage("what is sent does not come back");
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

void LcmBus::Handle() {
  if (receiver_) {
    receiver_->Receive([this](std::string_view channel, const std::uint8_t* data,
                              std::size_t size) { Take(channel, data, size); });
    return;
  }
  for (int i = 0; i < kMaxBurst && (i == 0 || Ready(0)); ++i) {
    const int status = lcm_handle(lcm_.get());
    if (callback_error_) std::rethrow_exception(std::exchange(callback_error_, nullptr));
    if (status != 0) throw SystemError(fmt::format("LCM stopped receiving on {}", url_));
  }
}

std::vector<Packet> LcmBus::Receive(std::int64_t timeout_us) {
  // What LCM dispatches may all be rejected: wait on for the rest of the time.
  const std::int64_t deadline_us = NowUs() + timeout_us;
  while (true) {
    const std::int64_t begin_us = NowUs();
    std::int64_t wait_us = std::max<std::int64_t>(deadline_us - begin_us, 0);
    if (!outage_.empty()) wait_us = std::max(probed_us_ + kProbeUs - begin_us, kProbeUs / 10);
    const bool ready = Ready(wait_us);
    if (ready) {
      Handle();
      if (tap_) tap_->on_burst();
      unanswered_ = false;
      waited_us_ = 0;
    } else {
      NoteWaited(NowUs() - begin_us);
    }
    const bool was_out = !outage_.empty();
    if (was_out) Probe();
    if (!ready || !inbox_.empty() || tap_ || was_out || NowUs() >= deadline_us) break;
  }
  counters_.received += static_cast<std::int64_t>(inbox_.size());
  return std::exchange(inbox_, {});
}

void LcmBus::OnLcmMessage(const lcm_recv_buf_t* message, const char* channel, void* bus) noexcept {
  auto* self = static_cast<LcmBus*>(bus);
  try {
    self->Take(channel, static_cast<const std::uint8_t*>(message->data), message->data_size);
  } catch (...) {
    self->callback_error_ = std::current_exception();
  }
}

void LcmBus::Take(std::string_view channel, const std::uint8_t* data, std::size_t size) {
  if (channel == kRoundTripChannel) {
    came_back_ |= std::string_view(reinterpret_cast<const char*>(data), size) == round_trip_;
  }
  if (tap_) {
    const Packet packet{std::string(channel), {data, data + size}};
    tap_->on_message(packet);
    if (std::find(tap_->heard.begin(), tap_->heard.end(), channel) == tap_->heard.end()) return;
  }
  if (!channel.starts_with("MUSTER_")) return;
  const Channel* row = FindChannel(channel);
  if (row == nullptr || size > static_cast<std::size_t>(row->max_bytes) + tag_bytes_) {
    ++counters_.rejected;
    return;
  }
  // The rest of a message in fragments comes through whatever its channel.
  if (!ComesThrough(*row, channels_)) return;
  inbox_.push_back({std::string(channel), {data, data + size}});
}

}  // namespace muster
