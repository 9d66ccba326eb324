#include "lcmtypes/bus/member_keys.h"

#include <fmt/format.h>
#include <sodium.h>

#include <algorithm>
#include <limits>

#include "base/check.h"
#include "base/object_reader.h"
#include "base/text.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster {
namespace {

constexpr std::int64_t kVersionOfKeys = 1;
constexpr std::string_view kHexKey = "64 hexadecimal digits";
constexpr std::string_view kBlock = "CLASS:FIRST-LAST, such as uav:0-14";

using KeyBytes = std::array<std::uint8_t, 32>;

void StartSodiumForMembers() { MUSTER_CHECK(sodium_init() >= 0, "libsodium"); }

std::string HexOf(const std::uint8_t* bytes, std::size_t n) {
  std::string digits(2 * n + 1, '\0');
  sodium_bin2hex(digits.data(), digits.size(), bytes, n);
  digits.pop_back();
  return digits;
}

std::optional<KeyBytes> KeyOfHex(std::string_view digits) {
  KeyBytes bytes{};
  std::size_t n = 0;
  const bool is_hex = sodium_hex2bin(bytes.data(), bytes.size(), digits.data(), digits.size(),
                                     nullptr, &n, nullptr) == 0;
  if (!is_hex || n != bytes.size() || digits.size() != 2 * bytes.size()) return {};
  return bytes;
}

Member MemberOfSeed(const KeyBytes& seed) {
  Member member;
  crypto_sign_seed_keypair(member.public_key.data(), member.secret_key.emplace().data(),
                           seed.data());
  return member;
}

Member Derive(const KeyBytes& run_key, std::string_view name) {
  KeyBytes seed{};
  const std::string text = fmt::format("muster process {}", name);
  crypto_generichash(seed.data(), seed.size(), reinterpret_cast<const std::uint8_t*>(text.data()),
                     text.size(), run_key.data(), run_key.size());
  return MemberOfSeed(seed);
}

std::optional<AgentBlock> BlockOf(std::string_view text) {
  const std::size_t colon = text.find(':');
  const std::size_t dash = text.find('-', colon == std::string_view::npos ? 0 : colon);
  if (colon == std::string_view::npos || dash == std::string_view::npos) return {};
  constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
  const auto kind = FromString<AgentKind>(text.substr(0, colon));
  const auto first = ToInteger(text.substr(colon + 1, dash - colon - 1), 0);
  const auto last = ToInteger(text.substr(dash + 1), 0);
  if (!kind || !first || !last || *first > *last || *last > kMost) return {};
  return AgentBlock{*kind, static_cast<std::int32_t>(*first), static_cast<std::int32_t>(*last)};
}

Member ReadMember(const ObjectReader& reader) {
  reader.AllowOnly({"public", "secret", "agents"});
  Member member;
  const std::optional<KeyBytes> key = KeyOfHex(reader.String("public"));
  if (!key) reader.Fail("public", "another text", kHexKey);
  if (reader.Has("secret")) {
    const std::optional<KeyBytes> seed = KeyOfHex(reader.String("secret"));
    if (!seed) reader.Fail("secret", "another text", kHexKey);
    member = MemberOfSeed(*seed);
    if (member.public_key != *key) reader.Fail("secret", "that of another key", "that of public");
  }
  member.public_key = *key;
  if (!reader.Has("agents")) return member;
  member.agents = BlockOf(reader.String("agents"));
  if (!member.agents) reader.Fail("agents", *reader.Optional("agents"), kBlock);
  return member;
}

/// What is signed: the channel's name, a NUL, the message.
std::vector<std::uint8_t> SignedText(const Packet& packet) {
  std::vector<std::uint8_t> text(packet.channel.begin(), packet.channel.end());
  text.push_back(0);
  text.insert(text.end(), packet.bytes.begin(), packet.bytes.end());
  return text;
}

bool ReportsOwn(const Packet& packet, const Member& sender) {
  if (!sender.agents) return false;
  const AgentBlock& own = *sender.agents;
  if (packet.channel == channel::kDriver) {
    const auto event = DecodeValid<event_t>(packet.bytes);
    const auto is_own = [&own](AgentKind kind, std::int32_t id) {
      return id < 0 || own.Has(kind, id);
    };
    return event && is_own(AgentKind::kUav, event->uav_id) &&
           is_own(AgentKind::kWorker, event->worker_id) &&
           is_own(AgentKind::kVehicle, event->vehicle_id);
  }
  if (const auto states = DecodeValid<agent_states_t>(packet.bytes)) {
    return std::all_of(states->agents.begin(), states->agents.end(), [&](const agent_t& agent) {
      return own.Has(static_cast<AgentKind>(states->kind), agent.id);
    });
  }
  const auto changes = DecodeValid<agent_changes_t>(packet.bytes);
  const auto kind = changes ? static_cast<AgentKind>(changes->kind) : AgentKind::kUav;
  return changes && own.Has(kind, changes->first_id) && own.Has(kind, changes->last_id) &&
         std::all_of(changes->agents.begin(), changes->agents.end(),
                     [&](const agent_t& agent) { return own.Has(kind, agent.id); });
}

/// An answer repeats a message without its signature.
bool RepeatsOwnReport(const Packet& packet, const std::string& name, const Member& sender) {
  const auto answer = DecodeValid<answer_t>(packet.bytes);
  if (!answer || !IsReports(answer->channel)) return false;
  const Packet repeated{answer->channel, answer->data};
  const std::optional<header_t> header = DecodeHeader(repeated);
  return header && header->sender == name && ReportsOwn(repeated, sender);
}

}  // namespace

MemberKeys MemberKeys::Of(const KeyBytes& run_key, std::int64_t run_id, std::string launcher,
                          const std::map<std::string, std::optional<AgentBlock>>& members) {
  StartSodiumForMembers();
  MUSTER_CHECK(members.contains(launcher), "{}", launcher);
  MemberKeys keys;
  keys.run_id_ = run_id;
  keys.launcher_ = std::move(launcher);
  for (const auto& [name, agents] : members) {
    Member& member = keys.members_[name] = Derive(run_key, name);
    member.agents = agents;
  }
  return keys;
}

MemberKeys MemberKeys::Parse(std::string_view json, const std::string& from) {
  StartSodiumForMembers();
  const JsonValue value = ParseJson(json, from);
  const ObjectReader reader(value, "", from);
  reader.AllowOnly({"version", "run_id", "launcher", "members"});
  reader.Expect("version", kVersionOfKeys);
  MemberKeys keys;
  keys.run_id_ = reader.Integer("run_id", std::numeric_limits<std::int64_t>::min(),
                                std::numeric_limits<std::int64_t>::max());
  keys.launcher_ = reader.String("launcher");
  const ObjectReader members = reader.Child("members");
  for (const auto& [name, unused] : reader.Required("members", "an object").members) {
    keys.members_[name] = ReadMember(members.Child(name));
  }
  if (!keys.members_.contains(keys.launcher_)) {
    reader.Fail("launcher", *reader.Optional("launcher"), "one of the members");
  }
  return keys;
}

std::string MemberKeys::Text(const std::vector<std::string>& owners) const {
  std::string text = fmt::format("{{\"version\":{},\"run_id\":{},\"launcher\":{},\"members\":{{",
                                 kVersionOfKeys, run_id_, JsonText(launcher_));
  for (const auto& [name, member] : members_) {
    fmt::format_to(std::back_inserter(text), "{}:{{\"public\":\"{}\"", JsonText(name),
                   HexOf(member.public_key.data(), member.public_key.size()));
    if (member.agents) {
      const AgentBlock& own = *member.agents;
      fmt::format_to(std::back_inserter(text), ",\"agents\":\"{}:{}-{}\"", ToString(own.kind),
                     own.first, own.last);
    }
    if (member.secret_key && std::find(owners.begin(), owners.end(), name) != owners.end()) {
      fmt::format_to(std::back_inserter(text), ",\"secret\":\"{}\"",
                     HexOf(member.secret_key->data(), crypto_sign_SEEDBYTES));
    }
    text += "},";
  }
  text.back() = '}';
  return text + "}\n";
}

const Member* MemberKeys::Find(std::string_view name) const {
  const auto found = members_.find(name);
  return found == members_.end() ? nullptr : &found->second;
}

bool MemberKeys::AreOf(const KeyBytes& run_key) const {
  return std::all_of(members_.begin(), members_.end(), [&](const auto& member) {
    return Derive(run_key, member.first).public_key == member.second.public_key;
  });
}

std::vector<std::uint8_t> MemberKeys::Sign(const Packet& packet) const {
  const std::optional<header_t> header = DecodeHeader(packet);
  const Member* const member = header ? Find(header->sender) : nullptr;
  if (member == nullptr || !member->secret_key) return {};
  std::vector<std::uint8_t> signature(crypto_sign_BYTES);
  const std::vector<std::uint8_t> text = SignedText(packet);
  crypto_sign_detached(signature.data(), nullptr, text.data(), text.size(),
                       member->secret_key->data());
  return signature;
}

bool MemberKeys::Proves(const Packet& packet, const std::vector<std::uint8_t>& signature) const {
  const std::optional<header_t> header = DecodeHeader(packet);
  const Member* const member = header ? Find(header->sender) : nullptr;
  if (member == nullptr || signature.size() != crypto_sign_BYTES) return false;
  const std::vector<std::uint8_t> text = SignedText(packet);
  if (crypto_sign_verify_detached(signature.data(), text.data(), text.size(),
                                  member->public_key.data()) != 0) {
    return false;
  }
  const std::string& sender = header->sender;
  const std::string_view name = packet.channel;
  if (!FindChannel(name)->AcceptsFrom(sender)) return false;
  if (IsReports(name) || name == channel::kDriver) return ReportsOwn(packet, *member);
  if (sender == launcher_) return true;
  if (name == channel::kFault || name == channel::kOrder || name == channel::kRestore) return false;
  if (sender == process_name::kWorld) return true;
  if (name == channel::kAnswer) return RepeatsOwnReport(packet, sender, *member);
  if (name != channel::kEvent || process_name::IsScheduler(sender)) return true;
  const auto event = DecodeValid<event_t>(packet.bytes);
  return event && (event->kind == NumberOf(EventKind::kFaultApplied) ||
                   event->kind == NumberOf(EventKind::kFaultEnded));
}

}  // namespace muster
