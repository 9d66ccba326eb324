#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace muster {

/// The whole text as a finite number; none for NaN, infinities, what a double cannot hold, and any
/// character too many.
std::optional<double> ToNumber(std::string_view text);

/// The whole text as a decimal integer in [low, high]; none otherwise.
std::optional<std::int64_t> ToInteger(std::string_view text, std::int64_t low = 0,
                                      std::int64_t high = std::numeric_limits<std::int64_t>::max());

/// The parts between the separators, one more than there are separators: "a,,b" has three.
std::vector<std::string> Split(std::string_view text, char separator);

/// Whether a UTF-8 text has control characters (U+0000 to U+001F, U+007F to U+009F).
bool HasControls(std::string_view text);
/// The text with each byte of a control character as \xHH: fit for a terminal.
std::string Printable(std::string_view text);

/// So many bytes of a UTF-8 text at most, without part of a character at the end.
std::string FirstBytes(std::string text, std::size_t most);

/// " (did you mean 'policy'?)" for the known word that is nearest to `text`; "" when none is near:
/// at most a third of its letters left out, put in, changed, or swapped with the next.
std::string DidYouMean(std::string_view text, const std::vector<std::string>& known);

}  // namespace muster
