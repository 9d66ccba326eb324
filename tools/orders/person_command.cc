#include "tools/orders/person_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/sha256.h"
#include "tools/orders/persons.h"

namespace muster::tools {
namespace {

/// Those of a file that may not be there yet.
std::vector<ListedPerson> PersonsOf(const std::string& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return {};
  return ReadPersons(file);
}

auto FindListed(std::vector<ListedPerson>* persons, const std::string& name) {
  return std::find_if(persons->begin(), persons->end(),
                      [&](const ListedPerson& person) { return person.name == name; });
}

void AddPerson(const Arguments& arguments, const std::string& file, const std::string& name) {
  std::vector<ListedPerson> persons = PersonsOf(file);
  if (FindListed(&persons, name) != persons.end()) {
    throw InputError("command line", "NAME", name,
                     "a name that is not in the file yet (remove it first)");
  }
  if (!arguments.Has("role")) {
    throw InputError("command line", "--role", "nothing", "watch, order or control");
  }
  ListedPerson person;
  person.name = name;
  person.role = *RoleOf(arguments.Get("role"));
  if (arguments.Has("until")) {
    person.until = ParseMoment(arguments.Get("until"));
    if (!person.until) {
      throw InputError("command line", "--until", arguments.Get("until"), kMomentExpected);
    }
  }
  if (arguments.Has("key-file")) {
    const std::string key_file = arguments.Get("key-file");
    std::error_code ignored;
    if (std::filesystem::exists(key_file, ignored)) {
      throw InputError("command line", "--key-file", key_file, "a file that is not there yet");
    }
    const PersonKey key{name, SigningKey::Fresh()};
    person.key = key.key.Public();
    persons.push_back(person);
    WritePersons(persons, file);
    WritePersonKey(key, key_file);
    fmt::print("{} signs with {}\n", name, key_file);
    return;
  }
  const std::string token = SigningKey::Fresh().Secret();  // 64 random digits
  person.token_sha256 = Sha256(token);
  persons.push_back(person);
  WritePersons(persons, file);
  fmt::print("token of {}, which is kept nowhere else: {}\n", name, token);
}

void RemovePerson(const std::string& file, const std::string& name) {
  std::vector<ListedPerson> persons = ReadPersons(file);
  const auto found = FindListed(&persons, name);
  if (found == persons.end()) {
    throw InputError("command line", "NAME", name, "a name in " + file);
  }
  persons.erase(found);
  WritePersons(persons, file);
}

void ListPersons(const std::string& file) {
  for (const ListedPerson& person : ReadPersons(file)) {
    fmt::print("{:<24} {:<8} {:<14} {}\n", person.name, ToString(person.role),
               !person.token_sha256.empty() && !person.key.empty() ? "token and key"
               : !person.token_sha256.empty()                      ? "token"
               : !person.key.empty()                               ? "key"
                                                                   : "neither",
               person.until ? "until " + person.until->text : "");
  }
}

}  // namespace

int PersonCommand(int argc, const char* const* argv) {
  Options options(
      "muster person",
      "Keeps a file of the persons who may order in a mission (docs/guide/persons.md), for muster "
      "run --persons. A mission that runs follows the file: a person who is removed may order "
      "nothing more.");
  options.Positional("what", "add|remove|list")
      .OneOf({"add", "remove", "list"})
      .Required("one of add, remove, list");
  options.Positional("file", "FILE").Required("the file of persons");
  options.Positional("name", "[NAME]");
  options
      .Add("role", "ROLE",
           "To add: watch (look, and ask what an order would change), order (also report, change "
           "and cancel tasks) or control (everything)")
      .OneOf({"watch", "order", "control"});
  options.Add("until", "TIME", "To add: may do nothing from then on, e.g. 2026-12-01T08:00:00Z");
  options.Add("key-file", "OUT",
              "To add: write a key to sign with, which only its owner may read, instead of making "
              "a token");
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const std::string what = arguments->Get("what"), file = arguments->Get("file");
  if (arguments->Has("name") == (what == "list")) {
    throw InputError("command line", "NAME", what == "list" ? arguments->Get("name") : "nothing",
                     what == "list" ? "none" : "a person's name");
  }
  if (what == "add") AddPerson(*arguments, file, arguments->Get("name"));
  if (what == "remove") RemovePerson(file, arguments->Get("name"));
  if (what == "list") ListPersons(file);
  return kExitOk;
}

}  // namespace muster::tools
