#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/order_kinds.h"

namespace muster {

/// What a person may do in a mission. Each role may also do what those before it may.
enum class Role : std::int8_t {
  kNone,     ///< nothing any more
  kWatch,    ///< look, and ask what an order would change
  kOrder,    ///< report tasks, change, hold and cancel them
  kControl,  ///< everything: agents, roads, zones, directives
};

std::string_view ToString(Role role);
/// None: there is no role of that name.
std::optional<Role> RoleOf(std::string_view name);

/// The role that such an order needs. Source: ours.
Role RoleFor(OrderKind kind);

/// One who may order, as the mission knows them from an order of the launcher.
struct Person {
  std::string name;
  Role role = Role::kNone;
  std::string key;  ///< Ed25519, public, 64 hexadecimal digits; "": the launcher signs for them
  std::string why;  ///< of kNone: "expired", "removed"
};

/// The person that signs for all others: the launcher, to which they have shown their token.
inline constexpr std::string_view kLauncherPerson = "launcher";

/// An order's JSON, and at its end who gave it and the proof of that:
/// {"order":"task_cancel","task":12,"signed":{"by":"Chief","key":"Chief","signature":"..."}}
struct SignedOrder {
  std::string order;  ///< without "signed"
  std::string by;     ///< the person who answers for it; "": it is not signed
  std::string key;    ///< the person whose key made the signature: the same, or the launcher
  std::string signature;
};

/// Throws InputError where what stands at the end is no signature.
SignedOrder SplitSignature(std::string_view json, const std::string& where);
/// The other way round.
std::string ToJson(const SignedOrder& order);
/// What is signed. An order of one run, with another id or by another person has another text.
/// Throws InputError where a name has control characters, which part the text.
std::string TextToSign(std::int64_t run_id, std::string_view id, std::string_view issuer,
                       const SignedOrder& order);

/// Why that person may give no such order; "": they may.
std::string WhyMayNot(std::span<const Person> persons, std::string_view by, OrderKind kind);

/// How an order names its issuer where `by` answers for it: "Chief", or "Mayor via Chief" where it
/// was given in the name of somebody else.
std::string IssuerText(std::string_view issuer, std::string_view by);
/// Whether it names them so.
bool NamesIssuer(std::string_view text, std::string_view by);

/// null: the mission knows nobody of that name.
const Person* FindPerson(std::span<const Person> persons, std::string_view name);

}  // namespace muster
