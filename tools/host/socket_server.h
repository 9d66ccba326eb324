#pragma once

#include <sys/socket.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace muster::tools {

/// Serves the clients of one socket, at most kMostClients at a time. One thread does so and waits
/// for no client. What a client is told is up to the derived class.
class SocketServer {
 public:
  static constexpr std::size_t kMostClients = 32;
  SocketServer(const SocketServer&) = delete;
  SocketServer& operator=(const SocketServer&) = delete;

 protected:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::milliseconds kIdle{1000};
  struct Client {
    virtual ~Client() = default;
    int fd = -1;
    std::string in;                          ///< said by the client; the server takes it out
    std::string out;                         ///< still to be sent
    bool ended = false;                      ///< it says no more
    bool last = false;                       ///< `out` is all that it gets
    Time until = Time::max();                ///< then it is given up
    std::chrono::milliseconds look = kIdle;  ///< it is served again after that at the latest
  };

  /// Clients above kMostClients are sent `full`.
  explicit SocketServer(std::string full) : full_(std::move(full)) {}
  virtual ~SocketServer();
  /// Binds the socket and listens. Throws SystemError, which names the place as `where`.
  void Listen(const sockaddr* address, socklen_t size, const std::string& where);
  void Start();
  /// Ends the thread, after a second at most. The derived class calls it when it is destroyed.
  void Stop();

  virtual std::unique_ptr<Client> Greet(Time now) = 0;
  /// Takes what the client has said, and adds what it is to be sent. `ending`: the server stops.
  virtual void Serve(Client* client, Time now, bool ending) = 0;

  int socket_ = -1;

 private:
  void Work();
  void Accept(Time now);
  static void Read(Client* client);
  /// Returns whether the connection is over.
  static bool Send(Client* client);

  const std::string full_;
  int wake_[2] = {-1, -1};  ///< a pipe; its writing end is closed when the thread is to end
  std::vector<std::unique_ptr<Client>> clients_;
  std::thread thread_;
};

}  // namespace muster::tools
