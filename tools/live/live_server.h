#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "tools/host/socket_server.h"
#include "tools/live/live_feed.h"
#include "tools/live/question.h"
#include "tools/orders/order_gate.h"

namespace muster::tools {

inline constexpr int kDefaultLivePort = 8087;

/// Serves the page and what happens on it (server-sent events) to browsers of this host: GET over
/// HTTP/1.1, one request a connection. With a gate, a client that has the token may give orders:
/// POST /orders (docs/guide/orders.md). Each client has kPatience for a request, and to take what
/// it is sent.
class LiveServer final : public SocketServer {
 public:
  static constexpr std::chrono::seconds kPatience{5};

  /// Binds 127.0.0.1:port (0: any free one) and starts no thread yet: the socket stays in the
  /// network namespace where it was made, even if the process enters another one. Throws
  /// SystemError when the port is taken.
  explicit LiveServer(int port);
  /// Says goodbye to the pages that listen, for a second at most, and ends.
  ~LiveServer() override;

  /// Starts to serve `feed`, which outlives the server's end.
  void Start(LiveFeed* feed) { Start(feed, nullptr); }
  /// The same; what is posted goes through `gate`, which outlives the server, too.
  void Start(LiveFeed* feed, OrderGate* gate);
  /// Questions about the run in that directory are answered: GET /why/NAME says why a task or an
  /// agent was commanded as it was, and with the token POST /what-if says what a directive would
  /// change. Programs of ours find the answers, at most kMostAsked at a time. Before Start().
  void AnswerAbout(const std::string& run) { run_ = run; }
  static constexpr std::size_t kMostAsked = 2;
  /// "http://127.0.0.1:8087/", with the token behind it where orders are taken; where persons are
  /// known with the word TOKEN, as each has one of their own.
  std::string url() const;

 private:
  struct Browser : Client {
    /// Its request is not complete yet.
    bool asks() const { return !listens && !last && order.empty() && question == nullptr; }
    bool listens = false;
    std::string order;  ///< whose answer it waits for, by id
    Time answer_by = {};
    std::unique_ptr<Question> question;  ///< that a program of ours answers
    LiveFeed::Reader reader = {};
    Time tell_at = {}, told_at = {};
  };

  std::unique_ptr<Client> Greet(Time now) override;
  void Serve(Client* client, Time now, bool ending) override;
  /// Answers the request when all of it is there.
  void Answer(Browser* client, Time now);
  /// GET /tiles/ZOOM/COLUMN/ROW: of the feed's base map.
  void AnswerTile(Browser* client, const std::string& path);
  /// Whether that header shows the page's token, or where persons are known one of theirs.
  bool MayAsk(std::string_view authorization) const;
  /// POST /orders, GET /orders/ID.
  void TakeOrder(Browser* client, const std::string& path, const std::string& body,
                 std::string_view token, Time now);
  void AnswerOrder(Browser* client, Time now);
  /// GET /why/NAME, POST /what-if.
  void Ask(Browser* client, const std::string& path, const std::string& body, Time now);
  void AnswerQuestion(Browser* client, Time now, bool ending);
  void Tell(Browser* client, Time now);

  int port_ = 0;
  LiveFeed* feed_ = nullptr;
  OrderGate* gate_ = nullptr;
  std::string token_;  ///< "": no orders are taken, or persons have tokens of their own
  std::string page_;
  std::string run_;        ///< "": nothing is asked about it
  std::size_t asked_ = 0;  ///< questions that are being answered
};

}  // namespace muster::tools
