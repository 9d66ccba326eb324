#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace muster {

/// A JSON value as it stands in the file: numbers keep their text, so that nothing is rounded
/// before it is known what unit they are in; members keep their order.
struct JsonValue {
  struct Member;  // a pair would need the whole type here
  enum class Type { kNull, kBoolean, kNumber, kString, kArray, kObject };
  Type type = Type::kNull;
  bool boolean = false;
  std::string text;  ///< a string's content or a number as written
  std::vector<JsonValue> items;
  std::vector<Member> members;
  /// Where it begins in the text, from 1; line 0: the text has one line alone.
  std::uint32_t line = 0, column = 0;

  /// The member of that key; nullptr when there is none.
  const JsonValue* Find(std::string_view key) const;

  /// " (line 3, column 12)", for messages; "" in a text of one line.
  std::string Position() const;

  /// How a message shows it: a number or a short string as written, else "an object", ...
  std::string Shown() const;
};

struct JsonValue::Member {
  std::string name;
  JsonValue value;
};

/// Parses a whole JSON text. Throws InputError naming `file`, line and column when it is not JSON
/// or a number is too large for a double, and naming the key when an object has a key twice or
/// nests deeper than any file of ours. Linear in the text (times the logarithm of an object's
/// size).
JsonValue ParseJson(std::string_view json, std::string_view file);

/// The text as a JSON string, with its quotes.
std::string JsonText(std::string_view text);

}  // namespace muster
