#include "tools/orders/web_client.h"

#include <fmt/format.h>
#include <httplib.h>

#include <utility>

#include "base/check.h"

namespace muster::tools {

bool IsWebAddress(const std::string& text) {
  return text.starts_with("http://") || text.starts_with("https://");
}

namespace {

/// "https://host:1/a?b": "host:1" and "/a?b".
std::pair<std::string, std::string> Parts(const std::string& address) {
  const std::size_t host = address.find("//") + 2;
  const std::size_t path = address.find('/', host);
  if (path == std::string::npos) return {address.substr(host), "/"};
  return {address.substr(host, path - host), address.substr(path)};
}

}  // namespace

std::string OnTheSameServer(const std::string& link, const std::string& address) {
  const std::string protocol = address.substr(0, address.find("//") + 2);
  const std::string host = Parts(address).first;
  if (link.starts_with('/') && !link.starts_with("//")) return protocol + host + link;
  if (!IsWebAddress(link) || Parts(link).first != host)
    throw SystemError(fmt::format("{}: it links to another server: {}", address, link));
  return protocol + host + Parts(link).second;
}

std::string Fetch(const std::string& address, const std::string& token, std::size_t most_bytes) {
  const auto [host, path] = Parts(address);
  httplib::Client client(address.substr(0, address.find("//") + 2) + host);
  if (!client.is_valid()) throw InputError(fmt::format("{}: no address of a web server", address));
  client.set_follow_location(token.empty());  // else it would tell the token to another server
  client.set_connection_timeout(10);
  client.set_read_timeout(30);
  httplib::Headers headers;
  if (!token.empty()) headers.emplace("Authorization", "Token " + token);
  std::string body;
  bool is_too_large = false;
  const httplib::Result result = client.Get(path, headers, [&](const char* data, std::size_t n) {
    is_too_large = body.size() + n > most_bytes;
    if (!is_too_large) body.append(data, n);
    return !is_too_large;
  });
  if (is_too_large)
    throw SystemError(fmt::format("{}: it answers more than {} MiB", address, most_bytes >> 20));
  if (!result)
    throw SystemError(
        fmt::format("{}: no answer: {}", address, httplib::to_string(result.error())));
  if (result->status != 200)
    throw SystemError(fmt::format("{}: it answers with status {}", address, result->status));
  return body;
}

}  // namespace muster::tools
