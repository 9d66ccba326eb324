#include "lcmtypes/bus/seal.h"

#include <fmt/format.h>
#include <sodium.h>

#include <limits>

#include "base/check.h"
#include "base/text.h"
#include "base/text_file.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/member_keys.h"

namespace muster {
namespace {

constexpr std::string_view kExpected =
    "64 hexadecimal digits, and the run id where it is of one run";
constexpr std::string_view kPerProcess = " per-process";
constexpr std::size_t kLongestText = 64 * 1024;  ///< of a process that knows all others' keys

void StartSodium() { MUSTER_CHECK(sodium_init() >= 0, "libsodium"); }

}  // namespace

std::string SodiumVersion() { return sodium_version_string(); }

Tag CutTag(Packet* packet) {
  const std::optional<std::size_t> behind = BytesBehindMessage(*packet);
  if (behind != kTagBytes && behind != kSignatureBytes) return {};
  const auto end = packet->bytes.end() - static_cast<std::ptrdiff_t>(*behind);
  Tag tag(end, packet->bytes.end());
  packet->bytes.erase(end, packet->bytes.end());
  return tag;
}

Packet WithTag(Packet packet, const Tag& tag) {
  packet.bytes.insert(packet.bytes.end(), tag.begin(), tag.end());
  return packet;
}

SealKey SealKey::Fresh(std::int64_t run_id) {
  StartSodium();
  SealKey key;
  randombytes_buf(key.bytes.data(), key.bytes.size());
  key.run_id = run_id;
  return key;
}

SealKey SealKey::Parse(std::string_view text, const std::string& from) {
  const auto fail = [&] { throw InputError(from, "key", "another text", kExpected); };
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.remove_suffix(1);
  SealKey key;
  const std::string_view digits = text.substr(0, 2 * key.bytes.size());
  std::size_t n = 0;
  if (sodium_hex2bin(key.bytes.data(), key.bytes.size(), digits.data(), digits.size(), nullptr, &n,
                     nullptr) != 0 ||
      n != key.bytes.size()) {
    fail();
  }
  text.remove_prefix(digits.size());
  if (text.empty()) return key;
  if (text.front() != ' ') fail();
  key.per_process = text.ends_with(kPerProcess);
  if (key.per_process) text.remove_suffix(kPerProcess.size());
  key.run_id = ToInteger(text.substr(1), std::numeric_limits<std::int64_t>::min());
  if (!key.run_id) fail();
  return key;
}

SealKey SealKey::Load(const std::string& file) {
  return Parse(ReadSecretLine(file, "key", kLongestText), file == "-" ? "stdin" : file);
}

std::string SealKey::Text() const {
  std::array<char, 2 * sizeof bytes + 1> digits{};
  sodium_bin2hex(digits.data(), digits.size(), bytes.data(), bytes.size());
  return fmt::format("{}{}{}\n", digits.data(), run_id ? fmt::format(" {}", *run_id) : "",
                     per_process ? kPerProcess : "");
}

SealKey SealKey::Of(std::int64_t run, const std::string& from) const {
  if (run_id && *run_id != run) {
    throw InputError(from, "key", fmt::format("that of run {}", *run_id),
                     fmt::format("one of run {}, or of no run", run));
  }
  if (run_id) return *this;
  StartSodium();
  SealKey derived;
  derived.run_id = run;
  const std::string text = fmt::format("muster run {}", run);
  crypto_generichash(derived.bytes.data(), derived.bytes.size(),
                     reinterpret_cast<const unsigned char*>(text.data()), text.size(), bytes.data(),
                     bytes.size());
  return derived;
}

Seal::Seal(const SealKey& key) : key_(key) {
  StartSodium();
  MUSTER_CHECK(key_.run_id.has_value(), "a run's key");
}

Seal::Seal(MemberKeys members) : members_(std::make_shared<const MemberKeys>(std::move(members))) {
  StartSodium();
}

Seal Seal::Load(const std::string& file, std::int64_t run_id) {
  const std::string from = file == "-" ? "stdin" : file;
  const std::string text = ReadSecretLine(file, "key", kLongestText);
  if (!text.starts_with('{')) {
    const SealKey key = SealKey::Parse(text, from);
    if (!key.per_process) return Seal(key.Of(run_id, from));
    throw InputError(from, "key", "that of the whole mission",
                     "one of a process, in keys/ of the run directory: it is sealed per process");
  }
  MemberKeys members = MemberKeys::Parse(text, from);
  if (members.run_id() != run_id) {
    throw InputError(from, "run_id", fmt::to_string(members.run_id()), fmt::to_string(run_id));
  }
  return Seal(std::move(members));
}

Tag Seal::TagOf(const Packet& packet) const {
  if (members_) return members_->Sign(packet);
  Tag tag(kTagBytes);
  crypto_generichash_state state;
  crypto_generichash_init(&state, key_.bytes.data(), key_.bytes.size(), kTagBytes);
  // With the NUL behind the name: no name and message make another pair's bytes.
  crypto_generichash_update(&state, reinterpret_cast<const unsigned char*>(packet.channel.c_str()),
                            packet.channel.size() + 1);
  crypto_generichash_update(&state, packet.bytes.data(), packet.bytes.size());
  crypto_generichash_final(&state, tag.data(), kTagBytes);
  return tag;
}

bool Seal::Holds(const Packet& packet, const Tag& tag) const {
  if (members_) return members_->Proves(packet, tag);
  // Takes the same time for all that are not the right one.
  return tag.size() == kTagBytes && sodium_memcmp(TagOf(packet).data(), tag.data(), kTagBytes) == 0;
}

Packet Seal::Closed(Packet packet) const {
  const Tag tag = TagOf(packet);
  return WithTag(std::move(packet), tag);
}

bool Seal::Open(Packet* packet) const {
  if (packet->bytes.size() < tag_bytes()) return false;
  const auto end = packet->bytes.end() - static_cast<std::ptrdiff_t>(tag_bytes());
  const Tag tag(end, packet->bytes.end());
  packet->bytes.erase(end, packet->bytes.end());
  if (Holds(*packet, tag)) return true;
  packet->bytes.insert(packet->bytes.end(), tag.begin(), tag.end());
  return false;
}

}  // namespace muster
