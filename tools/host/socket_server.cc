#include "tools/host/socket_server.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>

#include "base/check.h"
#include "tools/host/quiet_thread.h"

namespace muster::tools {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr milliseconds kGoodbye{1000};
constexpr milliseconds kLookAtEnd{5};
constexpr std::size_t kMostIn = 128 * 1024;
constexpr std::size_t kMostOut = 1 << 20;  // then the client is to read first

}  // namespace

SocketServer::~SocketServer() {
  close(socket_);
  close(wake_[0]);
}

void SocketServer::Listen(const sockaddr* address, socklen_t size, const std::string& where) {
  socket_ = socket(address->sa_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int yes = 1;
  if (socket_ < 0 || setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
      bind(socket_, address, size) != 0 || listen(socket_, kMostClients) != 0 ||
      pipe2(wake_, O_CLOEXEC) != 0) {
    throw SystemError(fmt::format("cannot listen at {}: {}", where, std::strerror(errno)));
  }
}

void SocketServer::Start() {
  thread_ = StartQuietThread([this] { Work(); });
}

void SocketServer::Stop() {
  close(wake_[1]);
  if (thread_.joinable()) thread_.join();
}

void SocketServer::Work() {
  std::optional<Time> end;
  while (true) {
    std::vector<pollfd> all = {{end ? -1 : wake_[0], POLLIN, 0}, {end ? -1 : socket_, POLLIN, 0}};
    milliseconds wait = end ? kLookAtEnd : kIdle;
    for (const auto& client : clients_) {
      int events = client->ended || client->out.size() > kMostOut ? 0 : POLLIN;
      if (!client->out.empty()) events |= POLLOUT;
      all.push_back({events != 0 ? client->fd : -1, static_cast<short>(events), 0});
      wait = std::min(
          {wait, client->look, std::chrono::ceil<milliseconds>(client->until - Clock::now())});
    }
    poll(all.data(), all.size(), static_cast<int>(std::max<std::int64_t>(wait.count(), 0)));
    const Time now = Clock::now();
    if (!end && all[0].revents != 0) end = now + kGoodbye;
    if (!end) Accept(now);
    std::erase_if(clients_, [&](const auto& client) {
      Read(client.get());
      Serve(client.get(), now, end.has_value());
      const bool over = Send(client.get()) || now >= client->until || (end && now >= *end);
      if (over) close(client->fd);
      return over;
    });
    if (end && clients_.empty()) return;
  }
}

void SocketServer::Accept(Time now) {
  while (true) {
    const int fd = accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) return;
    if (clients_.size() < kMostClients) {
      clients_.push_back(Greet(now));
      clients_.back()->fd = fd;
    } else {
      send(fd, full_.data(), full_.size(), MSG_NOSIGNAL);
      close(fd);
    }
  }
}

void SocketServer::Read(Client* client) {
  char buffer[16384];
  while (!client->ended && client->in.size() <= kMostIn && client->out.size() <= kMostOut) {
    const ssize_t got = recv(client->fd, buffer, sizeof buffer, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && errno == EAGAIN) return;
    if (got <= 0) client->ended = true;
    if (got > 0) client->in.append(buffer, static_cast<std::size_t>(got));
  }
}

bool SocketServer::Send(Client* client) {
  while (!client->out.empty()) {
    const ssize_t sent = send(client->fd, client->out.data(), client->out.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) return errno != EAGAIN;
    client->out.erase(0, static_cast<std::size_t>(sent));
  }
  // The client closes when it has read all; to close first might cut its answer off.
  if (client->last) shutdown(client->fd, SHUT_WR);
  return client->last && client->ended;
}

}  // namespace muster::tools
