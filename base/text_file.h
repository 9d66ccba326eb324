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

/// The first line of a file that its owner alone can read, or of stdin ("-"), at most `most_bytes`
/// of it. Throws InputError, naming `what`, where others could read the file.
std::string ReadSecretLine(const std::string& file, std::string_view what, std::size_t most_bytes);

}  // namespace muster
