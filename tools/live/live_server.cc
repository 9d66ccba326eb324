#include "tools/live/live_server.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "base/check.h"
#include "base/text.h"
#include "tools/report/page.h"
#include "tools/scenario/order_text.h"
#include "tools/tiles/base_map.h"

namespace muster::tools {
namespace {

using std::chrono::milliseconds;

constexpr const char* kHost = "127.0.0.1";
constexpr std::size_t kMostRequestBytes = 8192;
constexpr milliseconds kPace{250};        // between chunks to one page
constexpr milliseconds kLookForNews{50};  // for what is new
constexpr milliseconds kSilence{1000};
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
    if (colon == line.npos) continue;
    const std::string_view name = line.substr(0, colon);
    const std::string_view value = Trimmed(line.substr(colon + 1));
    if (SameLetters(name, "Host")) request.host = value;
    if (SameLetters(name, "Authorization")) request.authorization = value;
    if (SameLetters(name, "Content-Length")) {
      const auto length = ToInteger(std::string(value), 0, INT32_MAX);
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

/// Of "Bearer TOKEN"; "" of anything else.
std::string_view TokenOf(std::string_view authorization) {
  constexpr std::string_view kBearer = "Bearer ";
  return authorization.starts_with(kBearer) ? authorization.substr(kBearer.size()) : "";
}

/// Whether it is "Bearer TOKEN"; how long that takes to see says nothing of the token.
bool HasToken(std::string_view authorization, const std::string& token) {
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

LiveServer::LiveServer(int port) : SocketServer(Head("503 Service Unavailable", "", 0)) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  socklen_t size = sizeof address;
  auto* const bound = reinterpret_cast<sockaddr*>(&address);
  Listen(bound, size, fmt::format("{}:{}", kHost, port));
  MUSTER_CHECK(getsockname(socket_, bound, &size) == 0);
  port_ = ntohs(address.sin_port);
}

LiveServer::~LiveServer() {
  if (feed_ != nullptr) feed_->Close();
  Stop();
}

std::string LiveServer::url() const {
  const std::string token = gate_ == nullptr       ? ""
                            : gate_->has_persons() ? "#token=TOKEN"
                                                   : "#token=" + token_;
  return fmt::format("http://{}:{}/{}", kHost, port_, token);
}

void LiveServer::Start(LiveFeed* feed, OrderGate* gate) {
  feed_ = feed;
  gate_ = gate;
  if (gate_ != nullptr && !gate_->has_persons()) token_ = FreshOrderId() + FreshOrderId();
  page_ = LivePage("Live mission");
  SocketServer::Start();
}

std::unique_ptr<SocketServer::Client> LiveServer::Greet(Time now) {
  auto client = std::make_unique<Browser>();
  client->until = now + kPatience;
  return client;
}

void LiveServer::Serve(Client* one, Time now, bool ending) {
  auto* const client = static_cast<Browser*>(one);
  if (!client->asks()) client->in.clear();
  if (client->asks()) Answer(client, now);
  if (!client->order.empty()) AnswerOrder(client, now);
  if (client->question) AnswerQuestion(client, now, ending);
  if (client->listens && !client->last) Tell(client, now);
  client->look = !client->order.empty() || client->question ? kLookForAnswer
                 : client->listens                          ? kLookForNews
                                                            : kIdle;
  // A client that has not asked yet gets no answer any more.
  if (client->ended || (ending && client->asks())) client->until = now;
}

void LiveServer::AnswerTile(Browser* client, const std::string& path) {
  const TileFile& file = *feed_->tiles();
  TileId id;
  int end = 0;
  const bool is_tile =
      std::sscanf(path.c_str(), "/tiles/%2d/%8d/%8d%n", &id.zoom, &id.column, &id.row, &end) == 3 &&
      static_cast<std::size_t>(end) == path.size() && id.zoom >= 0 && id.zoom <= kMostZoom &&
      id.column >= 0 && id.row >= 0;
  const auto tell = [client](const nlohmann::ordered_json& json) {
    const std::string text =
        json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    client->out = Head("200 OK", "application/json", text.size()) + text;
  };
  if (path == "/tiles.json") return tell(AboutTiles(file));
  try {
    const auto bytes = is_tile ? file.Read(id) : std::nullopt;
    if (!bytes) {
      client->out = Head("404 Not Found", "", 0);
    } else if (file.info().vector) {
      tell(TileForPage(file, *bytes, kLiveTileUnits));
    } else {
      client->out = Head("200 OK", file.info().type, bytes->size()) + *bytes;
    }
  } catch (const InputError& error) {  // a damaged tile is none
    fmt::print(stderr, "{}\n", error.what());
    client->out = Head("404 Not Found", "", 0);
  }
}

bool LiveServer::MayAsk(std::string_view authorization) const {
  return gate_->has_persons() ? gate_->KnowsToken(TokenOf(authorization))
                              : HasToken(authorization, token_);
}

void LiveServer::TakeOrder(Browser* client, const std::string& path, const std::string& body,
                           std::string_view token, Time now) {
  try {
    client->order = body.empty() ? path.substr(std::string_view("/orders/").size())
                                 : gate_->Give(body, "page", token);
    client->last = false;
    client->answer_by = now + kAnswer;
  } catch (const NotAllowed& refusal) {
    const std::string text = RefusalText(refusal, body);
    client->out = Head(refusal.known() ? "403 Forbidden" : "401 Unauthorized", "application/json",
                       text.size()) +
                  text;
  } catch (const InputError& error) {
    const std::string text = ErrorText(error, body);
    client->out = Head("400 Bad Request", "application/json", text.size()) + text;
  }
}

void LiveServer::AnswerOrder(Browser* client, Time now) {
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
  client->until = now + kPatience;
}

void LiveServer::Ask(Browser* client, const std::string& path, const std::string& body, Time now) {
  const std::optional<std::vector<std::string>> command =
      body.empty() ? WhyCommand(run_, path.substr(std::string_view("/why/").size()))
                   : std::vector<std::string>{"what-if", run_, "-"};
  if (!command) {
    client->out = Head("404 Not Found", "", 0);
  } else if (asked_ >= kMostAsked) {
    client->out = Head("503 Service Unavailable", "", 0);
  } else {
    try {
      client->question = std::make_unique<Question>(*command, body);
      client->last = false;
      client->until = now + kPatience + Question::kMostTime;
      client->answer_by = now + Question::kMostTime;
      ++asked_;
    } catch (const std::exception&) {  // no process, no file
      client->out = Head("503 Service Unavailable", "", 0);
    }
  }
}

void LiveServer::AnswerQuestion(Browser* client, Time now, bool ending) {
  const bool is_late = ending || client->ended || now >= client->answer_by;
  const auto answer = client->question->Poll();
  if (!answer && !is_late) return;
  const char* const status = !answer        ? "503 Service Unavailable"
                             : answer->good ? "200 OK"
                                            : "409 Conflict";
  const std::string text = answer ? answer->text : "";
  client->out = Head(status, "text/plain; charset=utf-8", text.size()) + text;
  client->question.reset();
  --asked_;
  client->last = true;
  client->until = now + kPatience;
}

void LiveServer::Answer(Browser* client, Time now) {
  const std::size_t head = client->in.find("\r\n\r\n");
  const bool is_long = std::min(head, client->in.size()) > kMostRequestBytes;
  if (head == std::string::npos && !is_long) return;
  const auto request = ParseRequest(std::string_view(client->in).substr(0, head));
  const std::size_t length = request ? request->length : 0;
  if (!is_long && length <= kMostBodyBytes && client->in.size() < head + 4 + length) return;
  client->last = true;
  client->until = now + kPatience;
  const bool is_order =
      request && (request->path == "/orders" || request->path.starts_with("/orders/"));
  const bool is_what_if = request && request->path == "/what-if";
  const bool is_question =
      !run_.empty() && (is_what_if || (request && request->path.starts_with("/why/")));
  // Whose order it is, the gate finds out.
  const bool is_signed = gate_ != nullptr && gate_->has_persons() && request &&
                         request->path == "/orders" && request->method == "POST";
  if (is_long) {
    client->out = Head("431 Request Header Fields Too Large", "", 0);
  } else if (length > kMostBodyBytes) {
    client->out = Head("413 Content Too Large", "", 0);
  } else if (!request) {
    client->out = Head("400 Bad Request", "", 0);
  } else if (!IsOurs(request->host) || ((is_order || is_what_if) && gate_ == nullptr)) {
    client->out = Head("403 Forbidden", "", 0);
  } else if ((is_order || is_what_if) && !is_signed && !MayAsk(request->authorization)) {
    client->out = Head("401 Unauthorized", "", 0);
  } else if (is_order &&
             (request->method == "POST" ? request->path == "/orders" && request->length > 0
                                        : request->method == "GET" && request->path.size() > 8)) {
    TakeOrder(client, std::string(request->path), client->in.substr(head + 4, request->length),
              TokenOf(request->authorization), now);
  } else if (is_question && (request->method == "POST") == is_what_if &&
             is_what_if == (request->length > 0)) {
    Ask(client, std::string(request->path), client->in.substr(head + 4, request->length), now);
  } else if (request->method != "GET") {
    client->out = Head("405 Method Not Allowed", "", 0);
  } else if (request->path == "/") {
    client->out = Head("200 OK", "text/html; charset=utf-8", page_.size()) + page_;
  } else if (request->path == "/mission.geojson" || request->path == "/mission.cap") {
    const bool is_cap = request->path == "/mission.cap";
    const auto text = is_cap ? feed_->Cap() : feed_->GeoJson();
    const char* type = is_cap ? "application/atom+xml" : "application/geo+json";
    client->out =
        Head(text ? "200 OK" : "404 Not Found", text ? type : "", text ? text->size() : 0) +
        text.value_or("");
  } else if (request->path.starts_with("/tiles") && feed_->tiles() != nullptr) {
    AnswerTile(client, std::string(request->path));
  } else if (request->path == "/events") {
    client->out = Head("200 OK", "text/event-stream", {});
    client->last = false;
    client->listens = true;
    client->told_at = now;
  } else {
    client->out = Head("404 Not Found", "", 0);
  }
}

void LiveServer::Tell(Browser* client, Time now) {
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

}  // namespace muster::tools
