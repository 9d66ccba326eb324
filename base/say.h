#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string_view>
#include <utility>

namespace muster {

/// Writes to `out` and flushes it. Text that cannot be written (a closed terminal, a pipe without a
/// reader, a full disk) is dropped: a failed message must not end the work.
void SayTo(std::FILE* out, std::string_view text);

/// The same on stderr, formatted.
template <class... Arguments>
void Say(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  SayTo(stderr, fmt::format(format, std::forward<Arguments>(arguments)...));
}

}  // namespace muster
