#pragma once

#include <cstdint>
#include <map>
#include <muster/order_t.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tools/orders/persons.h"
#include "world/planned_orders.h"

namespace muster::tools {

/// Somebody gives an order, or asks, who may not.
class NotAllowed : public std::runtime_error {
 public:
  NotAllowed(bool known, const std::string& why) : std::runtime_error(why), known_(known) {}
  /// Whether they have shown who they are.
  bool known() const { return known_; }

 private:
  bool known_;
};

/// Who may order in a mission, and the launcher's key. A person shows a token, and the launcher
/// signs for them; or signs with a key of their own. The mission hears of the persons by orders
/// that the launcher signs, so that the world checks every order once more, and the log proves who
/// gave it. The file is read again when it changes: who is taken out of it may do nothing more.
class PersonsDesk {
 public:
  /// Signs with `key`. Throws InputError where the file is not right.
  PersonsDesk(std::string file, std::int64_t run_id, std::int64_t wall_us, SigningKey key);
  /// For the launcher's `start`-th start after the first, of a mission that was told of `persons`.
  void GoOn(const std::vector<Person>& persons, std::int64_t start);

  /// The secret key that it signs with.
  std::string Secret() const { return key_.Secret(); }

  /// What the mission is to know when it begins: an order for the launcher and for each person.
  std::vector<world::PlannedOrder> Planned();
  /// The lines of orders that are given with the mission (OrderLines), signed by the launcher.
  std::string SignedLines(const std::vector<world::PlannedOrder>& orders) const;
  /// What has changed since: the file, or somebody's time is over. Looks once a second.
  std::vector<order_t> Changes(std::int64_t wall_us);

  /// null: nobody has that token, or not any more.
  const ListedPerson* OfToken(std::string_view token) const;
  /// Signs the order for the one who has the token, or keeps the signature that came with it, if it
  /// is right. `given`: "by" and "signature", or "" both. Throws NotAllowed.
  void Prove(const SignedOrder& given, std::string_view token, world::PlannedOrder* order) const;

 private:
  /// What each may do then.
  std::map<std::string, Person> Now(std::int64_t wall_us) const;
  world::PlannedOrder OrderOf(const Person& person);
  std::string Sign(const std::string& order, std::string_view id, std::string_view issuer,
                   std::string_view by) const;
  /// Of the file; it changes when the file is written.
  std::string Mark() const;

  const std::string file_;
  const std::int64_t run_id_;
  const SigningKey key_;
  std::vector<ListedPerson> listed_;
  std::map<std::string, Person> told_;  ///< to the mission, by name
  std::string mark_;
  std::int64_t looked_us_ = 0, wall_us_ = 0;
  std::string ids_;  ///< what the numbers of its own orders begin with
  int n_ = 0;        ///< orders of its own so far
};

}  // namespace muster::tools
