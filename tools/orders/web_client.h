#pragma once

#include <string>

namespace muster::tools {

/// Begins with "http://" or "https://".
bool IsWebAddress(const std::string& text);

/// What a server answers to GET, of at most so many bytes. Certificates are checked. `token`:
/// "Authorization: Token ..."; "": none, and redirects are followed. Throws InputError where it is
/// no address, SystemError naming address and reason.
std::string Fetch(const std::string& address, const std::string& token, std::size_t most_bytes);

/// Where a link leads that the server of `address` gave: its path on that server, by the same
/// protocol (a token goes nowhere else). Throws SystemError where it names another server.
std::string OnTheSameServer(const std::string& link, const std::string& address);

}  // namespace muster::tools
