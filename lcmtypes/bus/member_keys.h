#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "lcmtypes/words.h"

namespace muster {

/// The agents of one class with ids first to last, which one process reports.
struct AgentBlock {
  AgentKind kind = AgentKind::kUav;
  std::int32_t first = 0, last = 0;

  bool Has(AgentKind of, std::int64_t id) const { return of == kind && first <= id && id <= last; }
};

/// A sender of a mission that is sealed per process. Keys are Ed25519's (RFC 8032).
struct Member {
  std::array<std::uint8_t, 32> public_key{};
  /// The secret half, where it is known: a process knows its own, the launcher all.
  std::optional<std::array<std::uint8_t, 64>> secret_key = {};
  std::optional<AgentBlock> agents = {};  ///< of an agent process
};

/// Who takes part in a mission that is sealed per process: each sender has a key of its own, and
/// the others know its public half.
class MemberKeys {
 public:
  /// The same keys each time: each is derived from the run's key and the sender's name.
  /// `launcher`: the sender that gives faults and orders; one of `members`.
  static MemberKeys Of(const std::array<std::uint8_t, 32>& run_key, std::int64_t run_id,
                       std::string launcher,
                       const std::map<std::string, std::optional<AgentBlock>>& members);
  /// Of Text(). Throws InputError, naming `from`, key and expectation; it never shows a secret.
  static MemberKeys Parse(std::string_view json, const std::string& from);
  /// One line of JSON, with the secret keys of these senders.
  std::string Text(const std::vector<std::string>& owners = {}) const;

  std::int64_t run_id() const { return run_id_; }
  const std::string& launcher() const { return launcher_; }
  /// The sender of that name; nullptr: none.
  const Member* Find(std::string_view name) const;
  /// Whether all public keys are those that are derived from this key of the run.
  bool AreOf(const std::array<std::uint8_t, 32>& run_key) const;

  /// Signs the packet as its sender; empty where its secret key is not known here.
  std::vector<std::uint8_t> Sign(const Packet& packet) const;
  /// Whether the packet's sender has signed it, and may say that: an agent process reports its own
  /// agents alone, the launcher alone gives faults and orders, and where an answer repeats a
  /// message of another sender, or the orders so far, it is the launcher's or the world's.
  bool Proves(const Packet& packet, const std::vector<std::uint8_t>& signature) const;

 private:
  std::int64_t run_id_ = 0;
  std::string launcher_;
  std::map<std::string, Member, std::less<>> members_;
};

}  // namespace muster
