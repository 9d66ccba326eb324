#include "base/text_file.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "base/check.h"

namespace muster {

std::string ReadTextFile(const std::string& file, std::string_view what, std::size_t most_bytes) {
  const auto refusal = [&](const std::string& reason) {
    return InputError(fmt::format("{}: cannot read {} from it: {}", file, what, reason));
  };
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(file.c_str(), "rb"),
                                                           &std::fclose);
  if (!in) throw refusal(std::strerror(errno));
  std::string text;
  std::array<char, 1 << 16> part;
  while (const std::size_t n = std::fread(part.data(), 1, part.size(), in.get())) {
    if (n > most_bytes - text.size()) {
      throw refusal(fmt::format("found more than {} bytes", most_bytes));
    }
    text.append(part.data(), n);
  }
  if (std::ferror(in.get()) != 0) throw refusal(std::strerror(errno));
  return text;
}

}  // namespace muster
