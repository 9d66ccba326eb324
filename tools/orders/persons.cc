#include "tools/orders/persons.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "base/check.h"
#include "base/json_tree.h"
#include "base/object_reader.h"
#include "base/text.h"
#include "base/text_file.h"
#include "lcmtypes/channels.h"
#include "tools/files/pending_file.h"

namespace muster::tools {
namespace {

constexpr std::size_t kMostFileBytes = 1 << 20;
constexpr std::size_t kMostPersonName = 100;
constexpr std::size_t kKeyDigits = 64;  ///< of a key, or of a token's SHA-256

std::string ReadDigits(const ObjectReader& item, std::string_view key) {
  if (!item.Has(key)) return "";
  std::string digits = item.String(key);
  if (digits.size() != kKeyDigits ||
      digits.find_first_not_of("0123456789abcdef") != std::string::npos) {
    item.Fail(key, *item.Optional(key), "64 hexadecimal digits (muster person makes them)");
  }
  return digits;
}

ListedPerson ReadPerson(const ObjectReader& item) {
  item.AllowOnly({"name", "role", "token_sha256", "key", "until"});
  ListedPerson person;
  person.name = item.String("name");
  if (person.name.empty() || person.name.size() > kMostPersonName || HasControls(person.name) ||
      person.name == kLauncherPerson || person.name == process_name::kWorld) {
    item.Fail("name", *item.Optional("name"),
              fmt::format("a name of at most {} bytes that is not {} or {}", kMostPersonName,
                          kLauncherPerson, process_name::kWorld));
  }
  const auto role = RoleOf(item.String("role"));
  if (!role || *role == Role::kNone) {
    item.Fail("role", *item.Optional("role"), "watch, order or control");
  }
  person.role = *role;
  person.token_sha256 = ReadDigits(item, "token_sha256");
  person.key = ReadDigits(item, "key");
  if (item.Has("until")) {
    person.until = ParseMoment(item.String("until"));
    if (!person.until) item.Fail("until", *item.Optional("until"), kMomentExpected);
  }
  return person;
}

std::vector<ListedPerson> ParsePersons(const std::string& text, const std::string& file) {
  const JsonValue tree = ParseJson(text, file);
  const ObjectReader top(tree, "", file);
  top.AllowOnly({"persons"});
  std::vector<ListedPerson> persons;
  std::set<std::string> names, tokens;
  for (const JsonValue& item : top.Array("persons")) {
    const ObjectReader reader = top.Element("persons", item, persons.size());
    persons.push_back(ReadPerson(reader));
    const ListedPerson& person = persons.back();
    if (!names.insert(person.name).second) reader.Fail("name", person.name, "each name once");
    if (!person.token_sha256.empty() && !tokens.insert(person.token_sha256).second) {
      reader.Fail("token_sha256", person.name, "a token that nobody else has");
    }
  }
  return persons;
}

}  // namespace

std::vector<ListedPerson> ReadPersons(const std::string& file) {
  return ParsePersons(ReadTextFile(file, "persons", kMostFileBytes), file);
}

void WritePersons(const std::vector<ListedPerson>& persons, const std::string& file) {
  auto list = nlohmann::ordered_json::array();
  for (const ListedPerson& person : persons) {
    auto& item = list.emplace_back();
    item["name"] = person.name;
    item["role"] = ToString(person.role);
    if (!person.token_sha256.empty()) item["token_sha256"] = person.token_sha256;
    if (!person.key.empty()) item["key"] = person.key;
    if (person.until) item["until"] = person.until->text;
  }
  const std::string text = nlohmann::ordered_json{{"persons", list}}.dump(2) + "\n";
  ParsePersons(text, file);
  WriteFile(file, text);
}

PersonKey LoadPersonKey(const std::string& file) {
  const std::string line = ReadSecretLine(file, "key", kKeyDigits + 1 + kMostPersonName);
  const std::size_t space = line.find(' ');
  const std::string name = space == std::string::npos ? "" : line.substr(space + 1);
  if (name.empty() || HasControls(name)) {
    throw InputError(file, "key", "another text", "the digits of a key, a space and a name");
  }
  return {name, SigningKey::Parse(line.substr(0, space), file)};
}

void WritePersonKey(const PersonKey& key, const std::string& file) {
  WriteFile(file, fmt::format("{} {}\n", key.key.Secret(), key.name), Readers::kOwner);
}

}  // namespace muster::tools
