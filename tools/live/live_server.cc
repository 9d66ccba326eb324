#include "tools/live/live_server.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "base/check.h"
#include "base/text.h"
#include "tools/host/quiet_thread.h"
#include "tools/report/page.h"
#include "tools/scenario/order_text.h"

namespace muster::tools {
namespace {

using std::chrono::milliseconds;

constexpr const char* kHost = "127.0.0.1";
constexpr std::size_t kMostRequestBytes = 8192;
constexpr milliseconds kPace{250};  // between chunks to one page
constexpr milliseconds kLook{50};   // for what is new
constexpr milliseconds kSilence{1000};
constexpr milliseconds kGoodbye{1000};
constexpr std::size_t kMostBodyBytes = 64 * 1024;
constexpr milliseconds kAnswer{4500};  // within kPatience
constexpr milliseconds kLookForAnswer{10};

std::string_view Trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  return text;
}

bool SameLetters(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
    return std::tolower(x) == std::tolower(y);
  });
}

/// Of an HTTP request, its first line and the headers that matter here.
struct Request {
  std::string_view method, path, host, authorization;
  std::size_t length = 0;  ///< of the body
};

std::optional<Request> ParseRequest(std::string_view text) {
  Request request;
  for (bool first = true; !text.empty(); first = false) {
    const std::size_t end = std::min(text.find("\r\n"), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 2, text.size()));
    if (first) {
      const std::size_t a = line.find(' ');
      const std::size_t b = line.rfind(' ');
      if (a == line.npos || b == a || !line.substr(b + 1).starts_with("HTTP/1.")) return {};
      request.method = line.substr(0, a);
      request.path = line.substr(a + 1, b - a - 1);
      request.path = request.path.substr(0, request.path.find('?'));
      continue;
    }
    const std::size_t colon = line.find(':');
    if (colon != line.npos && SameLetters(line.substr(0, colon), "Host")) {
      request.host = Trimmed(line.substr(colon + 1));
    }
    if (colon != line.npos && SameLetters(line.substr(0, colon), "Authorization")) {
      request.authorization = Trimmed(line.substr(colon + 1));
    }
    if (colon != line.npos && SameLetters(line.substr(0, colon), "Content-Length")) {
      const auto length = ToInteger(std::string(Trimmed(line.substr(colon + 1))), 0, INT32_MAX);
      if (!length) return {};
      request.length = static_cast<std::size_t>(*length);
    }
  }
  if (request.method.empty()) return {};
  return request;
}

/// A page of another site must not read ours through a name that it points to 127.0.0.1.
bool IsOurs(std::string_view host) {
  const std::string_view name = host.substr(0, host.find(':'));
  return name == kHost || name == "localhost";
}

/// "Bearer TOKEN"; how long that takes to see says nothing of the token.
bool MayOrder(std::string_view authorization, const std::string& token) {
  const std::string expected = "Bearer " + token;
  unsigned difference = authorization.size() == expected.size() ? 0 : 1;
  for (std::size_t i = 0; i < std::min(authorization.size(), expected.size()); ++i) {
    difference |=
        static_cast<unsigned char>(authorization[i]) ^ static_cast<unsigned char>(expected[i]);
  }
  return difference == 0;
}

/// `length`: of the body; none: until the connection ends.
std::string Head(std::string_view status, std::string_view type,
                 std::optional<std::size_t> length) {
  std::string head = fmt::format(
      "HTTP/1.1 {}\r\nConnection: close\r\nCache-Control: no-store\r\n"
      "X-Content-Type-Options: nosniff\r\n",
      status);
  if (!type.empty()) head += fmt::format("Content-Type: {}\r\n", type);
  if (length) head += fmt::format("Content-Length: {}\r\n", *length);
  return head + "\r\n";
}

}  // namespace

LiveServer::LiveServer(int port) {
  socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int yes = 1;
  setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  socklen_t size = sizeof address;
  const bool bound = socket_ >= 0 &&
                     bind(socket_, reinterpret_cast<const sockaddr*>(&address), size) == 0 &&
                     listen(socket_, kMostClients) == 0 &&
                     getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size) == 0 &&
                     pipe2(wake_, O_CLOEXEC) == 0;
  if (!bound) {
    const std::string why = std::strerror(errno);
    if (socket_ >= 0) close(socket_);
    throw SystemError(fmt::format("cannot listen at {}:{}: {}", kHost, port, why));
  }
  port_ = ntohs(address.sin_port);
}

LiveServer::~LiveServer() {
  if (feed_ != nullptr) feed_->Close();
  close(wake_[1]);
  if (thread_.joinable()) thread_.join();
  close(wake_[0]);
  close(socket_);
}

std::string LiveServer::url() const {
  return fmt::format("http://{}:{}/{}{}", kHost, port_, token_.empty() ? "" : "#token=", token_);
}

void LiveServer::Start(LiveFeed* feed, OrderGate* gate) {
  feed_ = feed;
  gate_ = gate;
  if (gate_ != nullptr) token_ = FreshOrderId() + FreshOrderId();
  page_ = LivePage("Live mission");
  thread_ = StartQuietThread([this] { Work(); });
}

void LiveServer::Work() {
  std::optional<Time> end;
  while (true) {
    const Time now = std::chrono::steady_clock::now();
    pollfd wake = {wake_[0], POLLIN, 0};
    if (!end && poll(&wake, 1, 0) > 0) end = now + kGoodbye;
    if (!end) Accept(now);
    for (Client& client : clients_) {
      Read(&client, now);
      if (!client.order.empty()) AnswerOrder(&client, now);
      if (client.listens && !client.last) Tell(&client, now);
      // Whoever has no question yet gets no answer any more.
      if (end && !client.listens && !client.last && client.order.empty()) Close(&client);
      Send(&client, now);
      if (now >= client.until || (end && now >= *end)) Close(&client);
    }
    std::erase_if(clients_, [](const Client& client) { return client.fd < 0; });
    if (end && clients_.empty()) return;
    Wait(now);
  }
}

void LiveServer::Wait(Time now) {
  // Once it is to end, the pipe is always ready.
  const bool ends = feed_->closed();
  std::vector<pollfd> all = {{ends ? -1 : wake_[0], POLLIN, 0}, {ends ? -1 : socket_, POLLIN, 0}};
  milliseconds wait = kSilence;
  if (ends) wait = kLook / 10;
  for (const Client& client : clients_) {
    // What a page that listens says is nothing; that it has gone shows by itself.
    const int events = client.out.empty() ? POLLIN : POLLOUT;
    all.push_back({client.fd, static_cast<short>(events), 0});
    if (client.listens) wait = std::min(wait, kLook);
    if (!client.order.empty()) wait = std::min(wait, kLookForAnswer);
    wait = std::min(wait, std::chrono::ceil<milliseconds>(client.until - now));
  }
  poll(all.data(), all.size(), static_cast<int>(std::max<std::int64_t>(wait.count(), 0)));
}

void LiveServer::Accept(Time now) {
  while (true) {
    const int fd = accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) return;
    Client& client = clients_.emplace_back();
    client.fd = fd;
    client.until = now + kPatience;
    if (clients_.size() <= kMostClients) continue;
    client.out = Head("503 Service Unavailable", "", 0);
    client.last = true;
    Send(&client, now);
    Close(&client);
    clients_.pop_back();
  }
}

void LiveServer::Read(Client* client, Time now) {
  char buffer[4096];
  while (client->fd >= 0) {
    const ssize_t got = recv(client->fd, buffer, sizeof buffer, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && errno == EAGAIN) return;
    if (got <= 0) return Close(client);
    if (client->listens || client->last || !client->order.empty()) continue;
    client->in.append(buffer, static_cast<std::size_t>(got));
    const std::size_t head = client->in.find("\r\n\r\n");
    if (head != std::string::npos) {
      const auto request = ParseRequest(std::string_view(client->in).substr(0, head));
      const std::size_t length = request ? request->length : 0;
      if (length > kMostBodyBytes) {
        client->out = Head("413 Content Too Large", "", 0);
        client->last = true;
        return;
      }
      if (client->in.size() < head + 4 + length) continue;
      return Answer(client, now);
    }
    if (client->in.size() <= kMostRequestBytes) continue;
    client->out = Head("431 Request Header Fields Too Large", "", 0);
    client->last = true;
  }
}

void LiveServer::TakeOrder(Client* client, const std::string& path, const std::string& body,
                           Time now) {
  try {
    client->order =
        body.empty() ? path.substr(std::string_view("/orders/").size()) : gate_->Give(body, "page");
    client->last = false;
    client->answer_by = now + kAnswer;
    client->until = now + kPatience;
  } catch (const InputError& error) {
    const std::string text = nlohmann::ordered_json{{"error", error.what()}}.dump(
        -1, ' ', false, nlohmann::json::error_handler_t::replace);
    client->out = Head("400 Bad Request", "application/json", text.size()) + text;
  }
}

void LiveServer::AnswerOrder(Client* client, Time now) {
  const auto answer = gate_->AnswerTo(client->order);
  if (!answer && gate_->knows(client->order) && now < client->answer_by) return;
  const std::string text =
      answer ? *answer : nlohmann::ordered_json{{"id", client->order}, {"pending", true}}.dump();
  const bool taken = answer && answer->find("\"taken\":") != std::string::npos;
  const char* const status = taken                         ? "200 OK"
                             : answer                      ? "409 Conflict"
                             : gate_->knows(client->order) ? "202 Accepted"
                                                           : "404 Not Found";
  client->out = Head(status, "application/json", text.size()) + text;
  client->order.clear();
  client->last = true;
}

void LiveServer::Answer(Client* client, Time now) {
  const std::size_t head = client->in.find("\r\n\r\n");
  const auto request = ParseRequest(std::string_view(client->in).substr(0, head));
  client->last = true;
  const bool is_order =
      request && (request->path == "/orders" || request->path.starts_with("/orders/"));
  if (!request) {
    client->out = Head("400 Bad Request", "", 0);
  } else if (!IsOurs(request->host) || (is_order && gate_ == nullptr)) {
    client->out = Head("403 Forbidden", "", 0);
  } else if (is_order && !MayOrder(request->authorization, token_)) {
    client->out = Head("401 Unauthorized", "", 0);
  } else if (is_order &&
             (request->method == "POST" ? request->path == "/orders" && request->length > 0
                                        : request->method == "GET" && request->path.size() > 8)) {
    TakeOrder(client, std::string(request->path), client->in.substr(head + 4, request->length),
              now);
  } else if (request->method != "GET") {
    client->out = Head("405 Method Not Allowed", "", 0);
  } else if (request->path == "/") {
    client->out = Head("200 OK", "text/html; charset=utf-8", page_.size()) + page_;
  } else if (request->path == "/events") {
    client->out = Head("200 OK", "text/event-stream", {});
    client->last = false;
    client->listens = true;
    client->told_at = now;
  } else {
    client->out = Head("404 Not Found", "", 0);
  }
}

void LiveServer::Tell(Client* client, Time now) {
  if (!client->out.empty()) return;
  client->until = now + kPatience;
  if (now < client->tell_at && !feed_->closed()) return;
  const bool is_all = feed_->worked_off();
  if (const auto chunk = feed_->Next(&client->reader, milliseconds(0))) {
    client->out = "event: chunk\ndata: " + *chunk + "\n\n";
    client->tell_at = now + kPace;
    client->told_at = now;
  } else if (is_all) {
    client->out = "event: bye\ndata:\n\n";
    client->last = true;
  } else if (now >= client->told_at + kSilence) {
    client->out = ":\n\n";  // shows whether anybody listens still
    client->told_at = now;
  }
}

void LiveServer::Send(Client* client, Time now) {
  while (client->fd >= 0 && !client->out.empty()) {
    const ssize_t sent = send(client->fd, client->out.data(), client->out.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0 && errno == EAGAIN) return;
    if (sent < 0) return Close(client);
    client->out.erase(0, static_cast<std::size_t>(sent));
    if (client->out.empty()) client->until = now + kPatience;
  }
  if (!client->last || !client->out.empty() || client->fd < 0) return;
  // It closes when it has read all; to close first might cut its answer off.
  shutdown(client->fd, SHUT_WR);
}

void LiveServer::Close(Client* client) {
  if (client->fd >= 0) close(client->fd);
  client->fd = -1;
}

}  // namespace muster::tools
