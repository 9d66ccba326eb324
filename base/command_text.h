#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace muster {

/// What a program said, fit for a terminal, a message and JSON: bytes that are not printable ASCII
/// as \xHH, and "..." for what is behind the first 500.
std::string Quote(std::string_view text);

/// The words of a command, apart at spaces; '...' and "..." keep spaces, a backslash outside of
/// '...' the character behind it. Nothing else is special: no shell reads it. None: a quotation
/// mark is open.
std::optional<std::vector<std::string>> WordsOf(std::string_view command);

}  // namespace muster
