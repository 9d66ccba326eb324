#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace muster::tools {

/// In zlib's format, which browsers call "deflate".
std::string Deflate(const std::string& bytes);

/// Whether bytes begin as a gzip stream does.
bool IsGzip(const std::string& bytes);

/// What was packed by gzip; none: it is damaged, or more than `most_bytes` came of it.
std::optional<std::string> Gunzip(const std::string& bytes, std::size_t most_bytes);

std::string Base64(const std::string& bytes);

}  // namespace muster::tools
