#include "tools/live/live_server.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>

#include <charconv>
#include <chrono>

#include "base/check.h"
#include "tools/report/page.h"

namespace muster::tools {
namespace {

constexpr const char* kHost = "127.0.0.1";
constexpr int kThreads = 32;  // one for each page that listens
constexpr int kMostListeners = 24;
constexpr std::chrono::milliseconds kPace{250};  // between chunks to one page
constexpr std::chrono::milliseconds kSilence{1000};
constexpr std::chrono::milliseconds kGoodbye{1000};

/// A page of another site must not read ours through a name that it points to 127.0.0.1.
bool ForUs(const httplib::Request& request) {
  const std::string host = request.get_header_value("Host");
  const std::string name = host.substr(0, host.find(':'));
  return name == kHost || name == "localhost";
}

class Listener {
 public:
  Listener(LiveFeed* feed, std::atomic<int>* count) : feed_(feed), count_(count) { ++*count_; }
  ~Listener() { --*count_; }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  bool Tell(httplib::DataSink* sink) {
    const auto chunk = feed_->Next(&reader_, kSilence);
    const auto write = [&](const std::string& text) {
      return sink->write(text.data(), text.size());
    };
    if (chunk) {
      if (!write("event: chunk\ndata: " + *chunk + "\n\n")) return false;
      feed_->Rest(kPace);
      return true;
    }
    if (feed_->closed()) {
      write("event: bye\ndata:\n\n");
      sink->done();
      return true;
    }
    return write(":\n\n");  // shows whether anybody listens still
  }

 private:
  LiveFeed* feed_;
  std::atomic<int>* count_;
  LiveFeed::Reader reader_;
};

}  // namespace

LiveServer::LiveServer(int port) : server_(std::make_unique<httplib::Server>()) {
  server_->set_socket_options([](socket_t fd) {
    const int yes = 1;
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    fcntl(fd, F_SETFD, FD_CLOEXEC);  // not for the mission's processes
  });
  server_->new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  server_->set_keep_alive_max_count(1);
  if (port == 0) {
    port_ = server_->bind_to_any_port(kHost);
    if (port_ <= 0) throw SystemError(fmt::format("there is no free port at {}", kHost));
  } else {
    if (!server_->bind_to_port(kHost, port)) {
      throw SystemError(
          fmt::format("cannot listen at {}:{}: it is taken, or not for you", kHost, port));
    }
    port_ = port;
  }
}

LiveServer::~LiveServer() {
  if (feed_ != nullptr) feed_->Close();
  // A server that stops cuts its answers short: first the pages hear goodbye, if they listen.
  const auto deadline = std::chrono::steady_clock::now() + kGoodbye;
  while (*listeners_ > 0 && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(kGoodbye / 500);
  }
  server_->stop();
  if (thread_.joinable()) thread_.join();
}

std::string LiveServer::url() const { return fmt::format("http://{}:{}/", kHost, port_); }

void LiveServer::Start(LiveFeed* feed) {
  feed_ = feed;
  server_->set_pre_routing_handler(
      [](const httplib::Request& request, httplib::Response& response) {
        response.set_header("Cache-Control", "no-store");
        response.set_header("X-Content-Type-Options", "nosniff");
        if (ForUs(request)) return httplib::Server::HandlerResponse::Unhandled;
        response.status = 403;
        return httplib::Server::HandlerResponse::Handled;
      });
  server_->Get("/", [](const httplib::Request&, httplib::Response& response) {
    response.set_content(LivePage("Live mission"), "text/html; charset=utf-8");
  });
  server_->Get("/events", [feed, listeners = listeners_](const httplib::Request&,
                                                         httplib::Response& response) {
    if (*listeners >= kMostListeners) {
      response.status = 503;
      return;
    }
    // The count is shared with the listeners, which may outlive this function.
    const auto listener = std::make_shared<Listener>(feed, listeners.get());
    response.set_chunked_content_provider(
        "text/event-stream", [listener, listeners](std::size_t, httplib::DataSink& sink) {
          return listener->Tell(&sink);
        });
  });
  thread_ = StartQuietThread([this] { server_->listen_after_bind(); });
  while (!server_->is_running()) std::this_thread::yield();
}

}  // namespace muster::tools
