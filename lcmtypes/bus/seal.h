#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
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
inline constexpr std::size_t kSignatureBytes = 64;  ///< a tag of a mission sealed per process
inline constexpr std::size_t kMostTagBytes = kSignatureBytes;

/// Takes the tag off: what is behind a whole message of its channel's type, where that is as long
/// as a tag or a signature. Empty, and the packet as it was, where there is none. Needs no key and
/// proves nothing.
Tag CutTag(Packet* packet);
/// The packet as it was before.
Packet WithTag(Packet packet, const Tag& tag);

class MemberKeys;

/// What a key file holds: 64 hexadecimal digits, and the run id where it is the key of that run
/// alone, with "per-process" behind it where that run is sealed per process. One without a run id
/// is for many runs; each has a key of its own that is derived from it.
struct SealKey {
  std::array<std::uint8_t, 32> bytes{};
  std::optional<std::int64_t> run_id = {};
  bool per_process = false;

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
/// that key, over the channel's name, a NUL and the message. In a run that is sealed per process a
/// tag is the sender's Ed25519 signature of the same text.
///
/// Source: RFC 7693 (keyed BLAKE2b is a message authentication code); libsodium's
/// crypto_generichash. RFC 8032.
class Seal {
 public:
  /// `key`: a run's.
  explicit Seal(const SealKey& key);
  /// Of a run that is sealed per process.
  explicit Seal(MemberKeys members);
  /// Of what a process gets as its key: a file that its owner alone can read, or the first line of
  /// stdin ("-"). Throws InputError.
  static Seal Load(const std::string& file, std::int64_t run_id);

  std::size_t tag_bytes() const { return members_ ? kSignatureBytes : kTagBytes; }
  /// nullptr: all members have the same key.
  const MemberKeys* members() const { return members_.get(); }

  /// Empty where the packet's sender has a key that is not known here.
  Tag TagOf(const Packet& packet) const;
  /// Whether that is the packet's tag, and of somebody who may say so.
  bool Holds(const Packet& packet, const Tag& tag) const;

  /// The packet with its tag.
  Packet Closed(Packet packet) const;
  /// Takes the tag off where it is the right one; else false, and the packet is as it was.
  bool Open(Packet* packet) const;

 private:
  SealKey key_;
  std::shared_ptr<const MemberKeys> members_;
};

}  // namespace muster
