#include "base/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace muster {
namespace {

template <class T>
std::optional<T> Whole(std::string_view text) {
  T value{};
  const char* last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (error != std::errc() || end != last) return std::nullopt;
  return value;
}

/// Letters left out, put in, changed, or swapped with their neighbour, that make `b` of `a`.
/// Source: optimal string alignment, the restricted Damerau-Levenshtein distance.
std::size_t Distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      const std::size_t changed = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, changed});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

/// How many bytes of control character the text begins with.
std::size_t ControlBytes(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (text.empty()) return 0;
  if (byte(0) < 0x20 || byte(0) == 0x7f) return 1;
  return text.size() > 1 && byte(0) == 0xc2 && byte(1) >= 0x80 && byte(1) < 0xa0 ? 2 : 0;
}

}  // namespace

bool HasControls(std::string_view text) {
  for (; !text.empty(); text.remove_prefix(1)) {
    if (ControlBytes(text) > 0) return true;
  }
  return false;
}

std::string Printable(std::string_view text) {
  std::string shown;
  while (!text.empty()) {
    const std::size_t controls = ControlBytes(text);
    for (std::size_t i = 0; i < controls; ++i) {
      shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[i]));
    }
    if (controls == 0) shown += text.front();
    text.remove_prefix(std::max<std::size_t>(controls, 1));
  }
  return shown;
}

std::string FirstBytes(std::string text, std::size_t most) {
  if (text.size() <= most) return text;
  while (most > 0 && (static_cast<unsigned char>(text[most]) & 0xC0) == 0x80) --most;
  text.resize(most);
  return text;
}

std::optional<double> ToNumber(std::string_view text) {
  const auto value = Whole<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::int64_t> ToInteger(std::string_view text, std::int64_t low, std::int64_t high) {
  const auto value = Whole<std::int64_t>(text);
  return value && *value >= low && *value <= high ? value : std::nullopt;
}

std::vector<std::string> Split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t at = 0;;) {
    const std::size_t next = text.find(separator, at);
    parts.emplace_back(text.substr(at, next - at));
    if (next == text.npos) return parts;
    at = next + 1;
  }
}

std::string DidYouMean(std::string_view text, const std::vector<std::string>& known) {
  constexpr std::size_t kLongest = 64;  // a word, not a file
  if (text.size() > kLongest) return "";
  std::size_t least = std::max<std::size_t>(1, text.size() / 3) + 1;
  std::string nearest;
  for (const std::string& word : known) {
    const std::size_t distance = Distance(text, word);
    if (distance >= least) continue;
    least = distance;
    nearest = fmt::format(" (did you mean '{}'?)", word);
  }
  return nearest;
}

}  // namespace muster
