#include "model/person.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/check.h"
#include "base/json_tree.h"
#include "base/object_reader.h"
#include "base/text.h"

namespace muster {
namespace {

constexpr std::string_view kRoles[] = {"none", "watch", "order", "control"};
/// Nothing else in a JSON text can read so: within a string its quotes have backslashes.
constexpr std::string_view kMark = R"(,"signed":{)";

constexpr std::string_view kVia = " via ";

}  // namespace

std::string_view ToString(Role role) { return kRoles[static_cast<std::size_t>(role)]; }

std::optional<Role> RoleOf(std::string_view name) {
  const auto* const found = std::find(std::begin(kRoles), std::end(kRoles), name);
  if (found == std::end(kRoles)) return {};
  return static_cast<Role>(found - std::begin(kRoles));
}

Role RoleFor(OrderKind kind) {
  const OrderSubject subject = RowOf(kind).subject;
  const bool needs_control = subject != OrderSubject::kNewTask && subject != OrderSubject::kTask &&
                             subject != OrderSubject::kOrder;  // that is one's own
  return needs_control ? Role::kControl : Role::kOrder;
}

SignedOrder SplitSignature(std::string_view json, const std::string& where) {
  SignedOrder order;
  const std::size_t mark = json.rfind(kMark);
  if (mark == std::string_view::npos || !json.ends_with("}}")) {
    order.order = json;
    return order;
  }
  order.order = fmt::format("{}}}", json.substr(0, mark));
  const std::size_t begin = mark + kMark.size() - 1;
  const JsonValue tree = ParseJson(json.substr(begin, json.size() - 1 - begin), where);
  const ObjectReader reader(tree, "signed", where);
  reader.AllowOnly({"by", "key", "signature"});
  order.by = reader.String("by");
  order.key = reader.String("key");
  order.signature = reader.String("signature");
  if (order.by.empty()) reader.Fail("by", "nothing", "a name");
  return order;
}

std::string ToJson(const SignedOrder& order) {
  if (order.by.empty()) return order.order;
  MUSTER_CHECK(order.order.size() > 2 && order.order.ends_with('}'), "an order");
  return fmt::format(R"({}{}"by":{},"key":{},"signature":{}}}}})",
                     std::string_view(order.order).substr(0, order.order.size() - 1), kMark,
                     JsonText(order.by), JsonText(order.key), JsonText(order.signature));
}

std::string TextToSign(std::int64_t run_id, std::string_view id, std::string_view issuer,
                       const SignedOrder& order) {
  for (const std::string_view name : {id, issuer, std::string_view(order.by)}) {
    if (HasControls(name)) {
      throw InputError("order", "signed", Printable(name), "names without control characters");
    }
  }
  return fmt::format("MUSTER_ORDER\n{}\n{}\n{}\n{}\n{}", run_id, id, issuer, order.by, order.order);
}

std::string IssuerText(std::string_view issuer, std::string_view by) {
  if (issuer.empty() || NamesIssuer(issuer, by)) return std::string(issuer.empty() ? by : issuer);
  return fmt::format("{}{}{}", issuer, kVia, by);
}

bool NamesIssuer(std::string_view text, std::string_view by) {
  return text == by || text.ends_with(fmt::format("{}{}", kVia, by));
}

const Person* FindPerson(std::span<const Person> persons, std::string_view name) {
  const auto found = std::find_if(persons.begin(), persons.end(),
                                  [&](const Person& person) { return person.name == name; });
  return found == persons.end() ? nullptr : &*found;
}

std::string WhyMayNot(std::span<const Person> persons, std::string_view by, OrderKind kind) {
  const Person* const person = FindPerson(persons, by);
  if (person == nullptr) {
    return by.empty() ? "the order is not signed"
                      : fmt::format("this mission knows nobody named {}", by);
  }
  if (person->role == Role::kNone) {
    return fmt::format("{} may not order any more: {}", by, person->why);
  }
  const std::string_view what = RowOf(kind).name;
  if (kind == OrderKind::kPerson && by != kLauncherPerson) {
    return fmt::format("{} comes from the launcher alone", what);
  }
  const Role needed = RoleFor(kind);
  if (person->role >= needed) return "";
  return fmt::format("{} has the role {}; {} needs {}", by, ToString(person->role), what,
                     ToString(needed));
}

}  // namespace muster
