#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/moment.h"
#include "lcmtypes/bus/signing.h"
#include "model/person.h"

namespace muster::tools {

/// One who may order, as a file of persons has them (docs/guide/persons.md).
struct ListedPerson {
  std::string name;
  Role role = Role::kWatch;
  std::string token_sha256;     ///< of the token that they show over HTTP; "": they have none
  std::string key;              ///< public, of the key that they sign with; "": they have none
  std::optional<Moment> until;  ///< from then on they may do nothing
};

/// Throws InputError naming file, key, value and what was expected.
std::vector<ListedPerson> ReadPersons(const std::string& file);
/// Writes the whole file, or leaves it as it was. Throws SystemError, and InputError where
/// ReadPersons() would.
void WritePersons(const std::vector<ListedPerson>& persons, const std::string& file);

/// A person's own key: a file of one line, "DIGITS NAME", which its owner alone can read.
struct PersonKey {
  std::string name;
  SigningKey key;
};

/// Throws InputError.
PersonKey LoadPersonKey(const std::string& file);
void WritePersonKey(const PersonKey& key, const std::string& file);

}  // namespace muster::tools
