#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "tools/live/live_feed.h"

namespace httplib {
class Server;
}

namespace muster::tools {

inline constexpr int kDefaultLivePort = 8087;

/// Serves the page and what happens on it (server-sent events) to browsers of this host.
class LiveServer {
 public:
  /// Binds 127.0.0.1:port (0: any free one) and starts no thread yet: the socket stays in the
  /// network where it was made, whatever network the process enters afterwards. Throws SystemError
  /// when the port is taken.
  explicit LiveServer(int port);
  /// Stops; returns when no thread is left.
  ~LiveServer();
  LiveServer(const LiveServer&) = delete;
  LiveServer& operator=(const LiveServer&) = delete;

  /// Starts to serve `feed`, which outlives the server's end.
  void Start(LiveFeed* feed);
  /// "http://127.0.0.1:8087/"
  std::string url() const;

 private:
  std::unique_ptr<httplib::Server> server_;
  int port_ = 0;
  LiveFeed* feed_ = nullptr;
  std::shared_ptr<std::atomic<int>> listeners_ = std::make_shared<std::atomic<int>>(0);
  std::thread thread_;
};

}  // namespace muster::tools
