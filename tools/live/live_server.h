#pragma once

#include <chrono>
#include <list>
#include <string>
#include <thread>

#include "tools/live/live_feed.h"
#include "tools/orders/order_gate.h"

namespace muster::tools {

inline constexpr int kDefaultLivePort = 8087;

/// Serves the page and what happens on it (server-sent events) to browsers of this host: GET over
/// HTTP/1.1, one request a connection. With a gate, whoever has the token may give orders: POST
/// /orders (docs/guide/orders.md). One thread waits for nobody: it serves at most kMostClients
/// at a time, and each of them has kPatience for a request, and to take what it is sent.
class LiveServer {
 public:
  static constexpr int kMostClients = 32;
  static constexpr std::chrono::seconds kPatience{5};

  /// Binds 127.0.0.1:port (0: any free one) and starts no thread yet: the socket stays in the
  /// network where it was made, whatever network the process enters afterwards. Throws SystemError
  /// when the port is taken.
  explicit LiveServer(int port);
  /// Says goodbye to the pages that listen, for a second at most, and ends.
  ~LiveServer();
  LiveServer(const LiveServer&) = delete;
  LiveServer& operator=(const LiveServer&) = delete;

  /// Starts to serve `feed`, which outlives the server's end.
  void Start(LiveFeed* feed) { Start(feed, nullptr); }
  /// The same; what is posted goes through `gate`, which outlives the server, too.
  void Start(LiveFeed* feed, OrderGate* gate);
  /// "http://127.0.0.1:8087/", with the token behind it where orders are taken.
  std::string url() const;

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct Client {
    int fd = -1;
    Time until;       ///< then it is given up
    std::string in;   ///< of its request
    std::string out;  ///< still to be sent
    bool listens = false;
    std::string order;  ///< whose answer it waits for, by id
    Time answer_by = {};
    bool last = false;  ///< `out` is all that it gets
    LiveFeed::Reader reader = {};
    Time tell_at = {}, told_at = {};
  };

  void Work();
  /// Until a client can be served, or the next is due.
  void Wait(Time now);
  void Accept(Time now);
  void Read(Client* client, Time now);
  void Answer(Client* client, Time now);
  /// POST /orders, GET /orders/ID.
  void TakeOrder(Client* client, const std::string& path, const std::string& body, Time now);
  void AnswerOrder(Client* client, Time now);
  void Tell(Client* client, Time now);
  void Send(Client* client, Time now);
  static void Close(Client* client);

  int socket_ = -1;
  int wake_[2] = {-1, -1};  ///< a pipe; its writing end is closed when it is to end
  int port_ = 0;
  LiveFeed* feed_ = nullptr;
  OrderGate* gate_ = nullptr;
  std::string token_;  ///< "": no orders are taken
  std::string page_;
  std::list<Client> clients_;
  std::thread thread_;
};

}  // namespace muster::tools
