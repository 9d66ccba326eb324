#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/host/socket_server.h"
#include "tools/orders/order_gate.h"
#include "tools/orders/order_signer.h"

namespace muster::tools {

inline constexpr const char* kOrderSocket = "orders.sock";

/// The socket of a running mission in its run directory, for its owner alone: a line of JSON is an
/// order, and each is answered by a line of JSON with what became of it (OrderGate::AnswerTo), as
/// soon as that is known.
class OrderSocket final : public SocketServer {
 public:
  /// Binds FOLDER/orders.sock. Throws SystemError.
  OrderSocket(const std::string& folder, OrderGate* gate);
  /// Answers what it still can, and takes the socket away.
  ~OrderSocket() override;

 private:
  struct Issuer : Client {
    std::vector<std::string> waiting;  ///< ids of orders without an answer
  };
  std::unique_ptr<Client> Greet(Time now) override;
  void Serve(Client* client, Time now, bool ending) override;

  const std::string file_;
  OrderGate* const gate_;
};

/// Orders without an answer that one who gives many has at a time.
inline constexpr std::size_t kMostOpen = 1000;

/// The other end.
class OrderClient {
 public:
  /// RUN is a run directory; orders are signed with the key in that file, "": not at all. Throws
  /// InputError where no mission runs there that takes orders.
  explicit OrderClient(const std::string& run, const std::string& key_file = "");
  ~OrderClient();
  OrderClient(const OrderClient&) = delete;
  OrderClient& operator=(const OrderClient&) = delete;

  /// Throws SystemError when the mission has gone.
  void Send(const std::string& line);
  /// The next answer; "" when none comes within `wait`, or the mission has gone (see gone()).
  std::string Receive(std::chrono::milliseconds wait);
  bool gone() const { return gone_; }

 private:
  std::optional<OrderSigner> signer_;
  int fd_ = -1;
  std::string in_;
  bool gone_ = false;
};

}  // namespace muster::tools
