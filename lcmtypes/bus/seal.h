#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lcmtypes/bus/bus.h"

namespace muster {

/// Of the libsodium that is linked, "1.0.18".
std::string SodiumVersion();

/// A tag behind the bytes of a packet; decoders of the message do not see it.
using Tag = std::vector<std::uint8_t>;
inline constexpr std::size_t kTagBytes = 16;

/// Takes the tag off: what is behind a whole message of its channel's type, where that is as long
/// as a tag. Empty, and the packet as it was, where there is none. Needs no key and proves nothing.
Tag CutTag(Packet* packet);
/// The packet as it was before.
Packet WithTag(Packet packet, const Tag& tag);

/// What a key file holds: 64 hexadecimal digits, and the run id where it is the key of that run
/// alone. One without a run id is for many runs; each has a key of its own that is derived from it.
struct SealKey {
  std::array<std::uint8_t, 32> bytes{};
  std::optional<std::int64_t> run_id = {};

  /// A new random key for a run.
  static SealKey Fresh(std::int64_t run_id);
  /// Throws InputError, naming `from`, where the text is no key. It never shows the text.
  static SealKey Parse(std::string_view text, const std::string& from);
  /// Parse() of a file that its owner alone can read, or of the first line of stdin ("-"). Throws
  /// InputError where others could read the file.
  static SealKey Load(const std::string& file);
  /// As Parse() takes it, with a newline.
  std::string Text() const;
  /// The key of that run. Throws InputError, naming `from`, where this one is another run's.
  SealKey Of(std::int64_t run, const std::string& from) const;
};

/// Tells the members of a run from others: a member has its key. A tag is BLAKE2b, 16 bytes, with
/// that key, over the channel's name, a NUL and the message.
///
/// Source: RFC 7693 (keyed BLAKE2b is a message authentication code); libsodium's
/// crypto_generichash.
class Seal {
 public:
  /// `key`: a run's.
  explicit Seal(const SealKey& key);

  Tag TagOf(const Packet& packet) const;
  /// Whether that is the packet's tag; takes the same time for all that are not.
  bool Holds(const Packet& packet, const Tag& tag) const;

  /// The packet with its tag.
  Packet Closed(Packet packet) const;
  /// Takes the tag off where it is the right one; else false, and the packet is as it was.
  bool Open(Packet* packet) const;

 private:
  SealKey key_;
};

}  // namespace muster
