#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace muster {

/// The whole of a file that a user names. Throws InputError ("FILE: cannot read WHAT from it:
/// REASON") where there is none, it is a folder, or it has more than `most_bytes`: a device or a
/// pipe may have no end.
std::string ReadTextFile(const std::string& file, std::string_view what,
                         std::size_t most_bytes = std::size_t{1} << 30);

}  // namespace muster
