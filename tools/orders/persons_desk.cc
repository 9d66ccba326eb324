#include "tools/orders/persons_desk.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "base/check.h"
#include "base/say.h"
#include "base/sha256.h"
#include "tools/scenario/order_text.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t kLookAgainUs = 1'000'000;

bool IsOver(const ListedPerson& person, std::int64_t wall_us) {
  return person.until && person.until->unix_us <= wall_us;
}

bool IsSame(const Person& a, const Person& b) {
  return a.role == b.role && a.key == b.key && a.why == b.why;
}

}  // namespace

PersonsDesk::PersonsDesk(std::string file, std::int64_t run_id, std::int64_t wall_us,
                         SigningKey key)
    : file_(std::move(file)), run_id_(run_id), key_(key), looked_us_(wall_us), wall_us_(wall_us) {
  mark_ = Mark();
  listed_ = ReadPersons(file_);
}

void PersonsDesk::GoOn(const std::vector<Person>& persons, std::int64_t start) {
  for (const Person& person : persons) told_[person.name] = person;
  ids_ = fmt::format("{}.", start);
}

std::string PersonsDesk::Mark() const {
  struct stat status {};
  if (stat(file_.c_str(), &status) != 0) return "gone";
  return fmt::format("{} {} {}.{}", status.st_ino, status.st_size, status.st_mtim.tv_sec,
                     status.st_mtim.tv_nsec);
}

std::map<std::string, Person> PersonsDesk::Now(std::int64_t wall_us) const {
  std::map<std::string, Person> persons;
  for (const ListedPerson& one : listed_) {
    const bool over = IsOver(one, wall_us);
    persons[one.name] = {one.name, over ? Role::kNone : one.role, one.key, over ? "expired" : ""};
  }
  for (const auto& [name, person] : told_) {
    if (name != kLauncherPerson && !persons.contains(name)) {
      persons[name] = {name, Role::kNone, "", "removed"};
    }
  }
  return persons;
}

world::PlannedOrder PersonsDesk::OrderOf(const Person& person) {
  Json json = {{"order", "person"}, {"name", person.name}, {"role", ToString(person.role)}};
  if (!person.key.empty()) json["key"] = person.key;
  if (!person.why.empty()) json["why"] = person.why;
  world::PlannedOrder planned{ParseOrder(json.dump(), "order"), json.dump()};
  planned.order.id = fmt::format("person:{}:{}{}", person.name, ids_, ++n_);
  planned.order.issuer = kLauncherPerson;
  told_[person.name] = person;
  return planned;
}

std::vector<world::PlannedOrder> PersonsDesk::Planned() {
  std::vector<world::PlannedOrder> orders = {
      OrderOf({std::string(kLauncherPerson), Role::kControl, key_.Public(), ""})};
  for (const auto& [name, person] : Now(wall_us_)) orders.push_back(OrderOf(person));
  return orders;
}

std::string PersonsDesk::SignedLines(const std::vector<world::PlannedOrder>& orders) const {
  std::istringstream lines(OrderLines(orders));
  std::string all, line;
  for (const world::PlannedOrder& planned : orders) {
    MUSTER_CHECK(std::getline(lines, line).good(), "a line for each order");
    all += Sign(line, planned.order.id, planned.order.issuer, kLauncherPerson) + "\n";
  }
  return all;
}

std::string PersonsDesk::Sign(const std::string& order, std::string_view id,
                              std::string_view issuer, std::string_view by) const {
  SignedOrder parts{order, std::string(by), std::string(kLauncherPerson), ""};
  parts.signature = key_.Sign(TextToSign(run_id_, id, issuer, parts));
  return ToJson(parts);
}

std::vector<order_t> PersonsDesk::Changes(std::int64_t wall_us) {
  wall_us_ = wall_us;
  // Also where the clock was set back.
  if (wall_us >= looked_us_ && wall_us < looked_us_ + kLookAgainUs) return {};
  looked_us_ = wall_us;
  if (std::string mark = Mark(); mark != mark_) {
    mark_ = std::move(mark);
    try {
      listed_ = ReadPersons(file_);
    } catch (const InputError& error) {
      Say("muster: {}; what it said before holds\n", error.what());
    }
  }
  std::vector<order_t> orders;
  for (const auto& [name, person] : Now(wall_us)) {
    const auto told = told_.find(name);
    if (told != told_.end() && IsSame(told->second, person)) continue;
    const world::PlannedOrder planned = OrderOf(person);
    order_t order{};
    order.id = planned.order.id;
    order.issuer = planned.order.issuer;
    order.json = Sign(planned.json, order.id, order.issuer, kLauncherPerson);
    orders.push_back(std::move(order));
  }
  return orders;
}

const ListedPerson* PersonsDesk::OfToken(std::string_view token) const {
  if (token.empty()) return nullptr;
  const std::string digits = Sha256(token);
  const auto found = std::find_if(listed_.begin(), listed_.end(), [&](const auto& person) {
    return person.token_sha256 == digits;
  });
  return found == listed_.end() || IsOver(*found, wall_us_) ? nullptr : &*found;
}

void PersonsDesk::Prove(const SignedOrder& given, std::string_view token,
                        world::PlannedOrder* planned) const {
  Order& order = planned->order;
  std::vector<Person> persons;
  for (const auto& [name, person] : Now(wall_us_)) persons.push_back(person);
  const auto require_role = [&](const std::string& by) {
    const std::string why = WhyMayNot(persons, by, order.kind);
    if (!why.empty()) throw NotAllowed(FindPerson(persons, by) != nullptr, why);
  };
  if (!given.by.empty()) {
    require_role(given.by);
    const SignedOrder parts{planned->json, given.by, given.by, given.signature};
    if (!NamesIssuer(order.issuer, given.by) ||
        !IsSignature(parts.signature, TextToSign(run_id_, order.id, order.issuer, parts),
                     FindPerson(persons, given.by)->key)) {
      throw NotAllowed(
          false, fmt::format("the signature is not {}'s for this order of this run", given.by));
    }
    planned->json = ToJson(parts);
    return;
  }
  const ListedPerson* const person = OfToken(token);
  if (person == nullptr) {
    throw NotAllowed(false, token.empty() ? "this mission takes signed orders only (--sign FILE)"
                                          : "nobody has that token, or not any more");
  }
  require_role(person->name);
  order.issuer = IssuerText(order.issuer, person->name);
  planned->json = Sign(planned->json, order.id, order.issuer, person->name);
}

}  // namespace muster::tools
