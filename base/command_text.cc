#include "base/command_text.h"

#include <fmt/format.h>

namespace muster {

std::string Quote(std::string_view text) {
  constexpr std::size_t kLongest = 500;
  std::string plain;
  for (const char c : text.substr(0, kLongest)) {
    const auto byte = static_cast<unsigned char>(c);
    plain += byte < 0x20 || byte > 0x7e ? fmt::format("\\x{:02x}", byte) : std::string(1, c);
  }
  return plain + (text.size() > kLongest ? "..." : "");
}

std::optional<std::vector<std::string>> WordsOf(std::string_view command) {
  std::vector<std::string> words;
  bool in_word = false;
  char quote = 0;
  for (std::size_t i = 0; i < command.size(); ++i) {
    char c = command[i];
    if (quote == 0 && c == ' ') {
      in_word = false;
      continue;
    }
    if (!in_word) words.emplace_back();
    in_word = true;
    if (c == quote) {
      quote = 0;
      continue;
    }
    if (quote == 0 && (c == '\'' || c == '"')) {
      quote = c;
      continue;
    }
    if (c == '\\' && quote != '\'' && i + 1 < command.size()) c = command[++i];
    words.back() += c;
  }
  return quote == 0 ? std::optional(words) : std::nullopt;
}

}  // namespace muster
