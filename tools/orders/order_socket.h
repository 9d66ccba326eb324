#pragma once

#include <chrono>
#include <list>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "tools/orders/order_gate.h"

namespace muster::tools {

inline constexpr const char* kOrderSocket = "orders.sock";

/// The socket of a running mission in its run directory, for its owner alone: a line of JSON is an
/// order, and for each comes a line of JSON with what became of it (OrderGate::AnswerTo), in
/// whatever order. One thread serves all and waits for nobody.
class OrderSocket {
 public:
  static constexpr std::size_t kMostClients = 32;

  /// Binds FOLDER/orders.sock. Throws SystemError.
  OrderSocket(const std::string& folder, OrderGate* gate);
  /// Answers what it still can, and takes the socket away.
  ~OrderSocket();
  OrderSocket(const OrderSocket&) = delete;
  OrderSocket& operator=(const OrderSocket&) = delete;

 private:
  struct Client {
    int fd = -1;
    std::string in, out;
    std::vector<std::string> waiting = {};  ///< ids
    bool ended = false;                     ///< says no more
  };
  void Work();
  void Read(Client* client);
  void Answer(Client* client);
  void Write(Client* client);

  const std::string file_;
  OrderGate* const gate_;
  int socket_ = -1;
  int wake_[2] = {-1, -1};
  std::list<Client> clients_;
  std::thread thread_;
};

/// The other end.
class OrderClient {
 public:
  /// RUN is a run directory. Throws InputError where no mission runs there that takes orders.
  explicit OrderClient(const std::string& run);
  ~OrderClient();
  OrderClient(const OrderClient&) = delete;
  OrderClient& operator=(const OrderClient&) = delete;

  /// Throws SystemError when the mission has gone.
  void Send(const std::string& line);
  /// The next answer; "" when none comes within `wait`, or the mission has gone (see gone()).
  std::string Receive(std::chrono::milliseconds wait);
  bool gone() const { return gone_; }

 private:
  int fd_ = -1;
  std::string in_;
  bool gone_ = false;
};

}  // namespace muster::tools
