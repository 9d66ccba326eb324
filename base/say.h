#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string_view>
#include <utility>

namespace muster {

/// Writes to `out` and flushes it. What cannot be written there (a closed terminal, a pipe that
/// nobody reads, a full disk) is left out: nobody's work ends for what it says on the way.
void SayTo(std::FILE* out, std::string_view text);

/// The same on stderr, formatted.
template <class... Arguments>
void Say(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  SayTo(stderr, fmt::format(format, std::forward<Arguments>(arguments)...));
}

}  // namespace muster
