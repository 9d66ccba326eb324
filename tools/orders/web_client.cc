#include "tools/orders/web_client.h"

#include <fmt/format.h>
#include <httplib.h>

#include "base/check.h"

namespace muster::tools {

bool IsWebAddress(const std::string& text) {
  return text.starts_with("http://") || text.starts_with("https://");
}

std::string Fetch(const std::string& address, const std::string& token, std::size_t most_bytes) {
  const std::size_t slash = address.find('/', address.find("//") + 2);
  httplib::Client client(address.substr(0, slash));
  if (!client.is_valid()) throw InputError(fmt::format("{}: no address of a web server", address));
  client.set_follow_location(token.empty());  // else it would tell the token to another server
  client.set_connection_timeout(10);
  client.set_read_timeout(30);
  httplib::Headers headers;
  if (!token.empty()) headers.emplace("Authorization", "Token " + token);
  std::string body;
  bool is_too_large = false;
  const httplib::Result result =
      client.Get(slash == std::string::npos ? "/" : address.substr(slash), headers,
                 [&](const char* data, std::size_t n) {
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
