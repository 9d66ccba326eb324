#include "tools/orders/order_socket.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/check.h"
#include "tools/host/quiet_thread.h"

namespace muster::tools {
namespace {

constexpr std::size_t kMostLine = 64 * 1024;
constexpr std::size_t kMostOut = 1 << 20;  ///< then it is to read first
constexpr int kLookMs = 10;                ///< while somebody waits for an answer

/// A path of any length: a socket's name has room for 107 bytes.
class Address {
 public:
  Address(const std::string& folder, const char* name) {
    folder_ = open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (folder_ < 0) return;
    address_.sun_family = AF_UNIX;
    const std::string path = fmt::format("/proc/self/fd/{}/{}", folder_, name);
    std::strncpy(address_.sun_path, path.c_str(), sizeof address_.sun_path - 1);
  }
  ~Address() {
    if (folder_ >= 0) close(folder_);
  }
  Address(const Address&) = delete;
  Address& operator=(const Address&) = delete;
  bool valid() const { return folder_ >= 0; }
  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&address_); }
  static socklen_t size() { return sizeof(sockaddr_un); }

 private:
  int folder_ = -1;
  sockaddr_un address_ = {};
};

}  // namespace

OrderSocket::OrderSocket(const std::string& folder, OrderGate* gate)
    : file_(fmt::format("{}/{}", folder, kOrderSocket)), gate_(gate) {
  const Address address(folder, kOrderSocket);
  socket_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const mode_t mask = umask(0177);
  const bool bound = address.valid() && socket_ >= 0 &&
                     bind(socket_, address.get(), Address::size()) == 0 &&
                     listen(socket_, kMostClients) == 0 && pipe2(wake_, O_CLOEXEC) == 0;
  const std::string why = std::strerror(errno);
  umask(mask);
  if (!bound) {
    if (socket_ >= 0) close(socket_);
    throw SystemError(fmt::format("cannot listen at {}: {}", file_, why));
  }
  thread_ = StartQuietThread([this] { Work(); });
}

OrderSocket::~OrderSocket() {
  close(wake_[1]);
  thread_.join();
  close(wake_[0]);
  close(socket_);
  unlink(file_.c_str());
}

void OrderSocket::Work() {
  using Clock = std::chrono::steady_clock;
  std::optional<Clock::time_point> end;
  while (true) {
    std::vector<pollfd> all = {{end ? -1 : wake_[0], POLLIN, 0}, {end ? -1 : socket_, POLLIN, 0}};
    bool somebody_waits = false;
    for (const Client& client : clients_) {
      int events = client.ended || client.out.size() > kMostOut ? 0 : POLLIN;
      if (!client.out.empty()) events |= POLLOUT;
      all.push_back({client.fd, static_cast<short>(events), 0});
      somebody_waits |= !client.waiting.empty();
    }
    poll(all.data(), all.size(), somebody_waits || end ? kLookMs : -1);
    if (!end && all[0].revents != 0) end = Clock::now() + std::chrono::seconds(1);
    if (!end) {
      const int fd = accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
      if (fd >= 0 && clients_.size() < kMostClients) {
        clients_.emplace_back().fd = fd;
      } else if (fd >= 0) {
        close(fd);
      }
    }
    for (Client& client : clients_) {
      Read(&client);
      Answer(&client);
      Write(&client);
      const bool done = client.waiting.empty() && client.out.empty() && (client.ended || end);
      if (client.fd >= 0 && (done || (end && Clock::now() >= *end))) {
        close(client.fd);
        client.fd = -1;
      }
    }
    std::erase_if(clients_, [](const Client& client) { return client.fd < 0; });
    if (end && clients_.empty()) return;
  }
}

void OrderSocket::Read(Client* client) {
  char buffer[16384];
  while (!client->ended && client->fd >= 0 && client->out.size() <= kMostOut) {
    const ssize_t got = recv(client->fd, buffer, sizeof buffer, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && errno == EAGAIN) break;
    if (got <= 0) client->ended = true;
    if (got > 0) client->in.append(buffer, static_cast<std::size_t>(got));
    for (std::size_t end = 0; (end = client->in.find('\n')) != std::string::npos;) {
      const std::string line = client->in.substr(0, end);
      client->in.erase(0, end + 1);
      try {
        client->waiting.push_back(gate_->Give(line, "local"));
      } catch (const InputError& error) {
        client->out += nlohmann::ordered_json{{"error", error.what()}}.dump(
                           -1, ' ', false, nlohmann::json::error_handler_t::replace) +
                       "\n";
      }
    }
    if (client->in.size() > kMostLine) client->ended = true;
  }
}

void OrderSocket::Answer(Client* client) {
  std::erase_if(client->waiting, [&](const std::string& id) {
    const auto answer = gate_->AnswerTo(id);
    if (answer) client->out += *answer + "\n";
    return answer.has_value();
  });
}

void OrderSocket::Write(Client* client) {
  while (client->fd >= 0 && !client->out.empty()) {
    const ssize_t sent = send(client->fd, client->out.data(), client->out.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0 && errno == EAGAIN) return;
    if (sent < 0) {
      close(client->fd);
      client->fd = -1;
      return;
    }
    client->out.erase(0, static_cast<std::size_t>(sent));
  }
}

OrderClient::OrderClient(const std::string& run) {
  const Address address(run, kOrderSocket);
  fd_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (address.valid() && fd_ >= 0 && connect(fd_, address.get(), Address::size()) == 0) return;
  if (fd_ >= 0) close(fd_);
  throw InputError(
      fmt::format("{}: no mission runs here that takes orders (muster run --take-orders)", run));
}

OrderClient::~OrderClient() { close(fd_); }

void OrderClient::Send(const std::string& line) {
  std::string rest = line + "\n";
  while (!rest.empty()) {
    const ssize_t sent = send(fd_, rest.data(), rest.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) throw SystemError("the mission takes no more orders: it has ended");
    rest.erase(0, static_cast<std::size_t>(sent));
  }
}

std::string OrderClient::Receive(std::chrono::milliseconds wait) {
  const auto until = std::chrono::steady_clock::now() + wait;
  while (true) {
    const std::size_t end = in_.find('\n');
    if (end != std::string::npos) {
      std::string line = in_.substr(0, end);
      in_.erase(0, end + 1);
      return line;
    }
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
    pollfd one = {fd_, POLLIN, 0};
    const int ready = poll(&one, 1, static_cast<int>(std::max<std::int64_t>(left.count(), 0)));
    if (ready < 0 && errno == EINTR) return "";
    if (ready <= 0) return "";
    char buffer[16384];
    const ssize_t got = recv(fd_, buffer, sizeof buffer, 0);
    if (got <= 0) {
      gone_ = true;
      return "";
    }
    in_.append(buffer, static_cast<std::size_t>(got));
  }
}

}  // namespace muster::tools
