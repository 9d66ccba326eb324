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

#include "base/check.h"

namespace muster::tools {
namespace {

constexpr std::size_t kMostLine = 64 * 1024;
constexpr std::chrono::milliseconds kLook{10};  ///< while a client waits for an answer

/// A path of any length: a socket's name has room for 107 bytes.
class Address {
 public:
  Address(const std::string& folder, const char* name) {
    folder_ = open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
    address_.sun_family = AF_UNIX;
    const std::string path = fmt::format("/proc/self/fd/{}/{}", folder_, name);
    std::strncpy(address_.sun_path, path.c_str(), sizeof address_.sun_path - 1);
  }
  ~Address() {
    if (folder_ >= 0) close(folder_);
  }
  Address(const Address&) = delete;
  Address& operator=(const Address&) = delete;
  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&address_); }
  static socklen_t size() { return sizeof(sockaddr_un); }

 private:
  int folder_ = -1;
  sockaddr_un address_ = {};
};

/// New files are for their owner alone.
struct OwnerAlone {
  const mode_t before = umask(0177);
  ~OwnerAlone() { umask(before); }
};

}  // namespace

OrderSocket::OrderSocket(const std::string& folder, OrderGate* gate)
    : SocketServer(""), file_(fmt::format("{}/{}", folder, kOrderSocket)), gate_(gate) {
  const Address address(folder, kOrderSocket);
  {
    const OwnerAlone mask;
    Listen(address.get(), Address::size(), file_);
  }
  Start();
}

OrderSocket::~OrderSocket() {
  Stop();
  unlink(file_.c_str());
}

std::unique_ptr<SocketServer::Client> OrderSocket::Greet(Time) {
  return std::make_unique<Issuer>();
}

void OrderSocket::Serve(Client* one, Time now, bool ending) {
  auto* const client = static_cast<Issuer*>(one);
  std::size_t begin = 0, end = 0;
  for (; (end = client->in.find('\n', begin)) - begin <= kMostLine; begin = end + 1) {
    const std::string order = client->in.substr(begin, end - begin);
    try {
      client->waiting.push_back(gate_->Give(order, "local", ""));
    } catch (const NotAllowed& refusal) {
      client->out += RefusalText(refusal, order) + "\n";
    } catch (const InputError& error) {
      client->out += ErrorText(error, order) + "\n";
    }
  }
  client->in.erase(0, begin);
  if (client->in.size() > kMostLine) client->ended = true;
  std::erase_if(client->waiting, [&](const std::string& id) {
    const auto answer = gate_->AnswerTo(id);
    if (answer) client->out += *answer + "\n";
    return answer.has_value();
  });
  client->look = client->waiting.empty() ? kIdle : kLook;
  client->last = client->ended && client->waiting.empty();
  if (ending && client->waiting.empty() && client->out.empty()) client->until = now;
}

OrderClient::OrderClient(const std::string& run, const std::string& key_file) {
  if (!key_file.empty()) signer_.emplace(key_file, run);
  const Address address(run, kOrderSocket);
  fd_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd_ >= 0 && connect(fd_, address.get(), Address::size()) == 0) return;
  if (fd_ >= 0) close(fd_);
  throw InputError(
      fmt::format("{}: no mission runs here that takes orders (muster run --take-orders)", run));
}

OrderClient::~OrderClient() { close(fd_); }

void OrderClient::Send(const std::string& line) {
  std::string rest = (signer_ ? signer_->Sign(line) : line) + "\n";
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
