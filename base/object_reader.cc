#include "base/object_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "base/text.h"

namespace muster {

using Type = JsonValue::Type;

ObjectReader::ObjectReader(const JsonValue& value, std::string path, std::string_view file)
    : value_(value), path_(std::move(path)), file_(file) {
  if (value.type != Type::kObject) Fail("", value, "an object");
}

void ObjectReader::AllowOnly(std::initializer_list<std::string_view> keys) const {
  for (const auto& [name, value] : value_.members) {
    if (std::find(keys.begin(), keys.end(), name) != keys.end()) continue;
    // Not as a key path: the name may hold anything.
    JsonValue shown = value;
    shown.type = Type::kString;
    shown.text = name;
    throw InputError(file_, (path_.empty() ? "top level" : path_) + value.Position(),
                     "the unknown key " + shown.Shown(),
                     fmt::format("only {}", fmt::join(keys, ", ")));
  }
}

const JsonValue& ObjectReader::Required(std::string_view key, std::string_view expected) const {
  const JsonValue* value = Optional(key);
  if (value == nullptr) Fail(key, "no such key", expected);
  return *value;
}

double ObjectReader::Number(std::string_view key, Unit unit, double low, double high) const {
  return ReadNumber(key, Required(key, "a number"), unit, low, high);
}

double ObjectReader::ReadNumber(std::string_view key, const JsonValue& value, Unit unit, double low,
                                double high) const {
  const double amount = value.type == Type::kNumber ? FromText(value.text, kOne) : std::nan("");
  if (amount >= low && amount <= high) return FromText(value.text, unit);
  Fail(key, value,
       low == -kMost   ? std::string("a number")
       : high == kMost ? fmt::format("a number of at least {}", low)
                       : fmt::format("a number in [{}, {}]", low, high));
}

TimeUs ObjectReader::Time(std::string_view key, long double unit_us) const {
  const double most = kMaxMinutes * static_cast<double>(kMinute / unit_us);
  static_cast<void>(Number(key, kOne, 0, most));
  return TimeFromText(Required(key, "a number").text, unit_us);
}

std::int64_t ObjectReader::Integer(std::string_view key, std::int64_t low,
                                   std::int64_t high) const {
  return ReadInteger(key, Required(key, fmt::format("an integer in [{}, {}]", low, high)), low,
                     high);
}

std::int64_t ObjectReader::ReadInteger(std::string_view key, const JsonValue& value,
                                       std::int64_t low, std::int64_t high) const {
  const double number = value.type == Type::kNumber ? FromText(value.text, kOne) : std::nan("");
  const bool is_integer = number == std::floor(number) && std::abs(number) <= 0x1p53;
  if (!is_integer || number < static_cast<double>(low) || number > static_cast<double>(high)) {
    Fail(key, value, fmt::format("an integer in [{}, {}]", low, high));
  }
  return static_cast<std::int64_t>(number);
}

bool ObjectReader::Boolean(std::string_view key, bool otherwise) const {
  const JsonValue* value = Optional(key);
  if (value == nullptr) return otherwise;
  if (value->type != Type::kBoolean) Fail(key, *value, "true or false");
  return value->boolean;
}

std::string ObjectReader::String(std::string_view key) const {
  const JsonValue& value = Required(key, "a string");
  if (value.type != Type::kString) Fail(key, value, "a string");
  return value.text;
}

const std::vector<JsonValue>& ObjectReader::Array(std::string_view key) const {
  const JsonValue& value = Required(key, "an array");
  if (value.type != Type::kArray) Fail(key, value, "an array");
  return value.items;
}

void ObjectReader::Expect(std::string_view key, std::int64_t number) const {
  const std::string expected = fmt::to_string(number);
  const JsonValue& value = Required(key, expected);
  if (value.type != Type::kNumber || value.text != expected) Fail(key, value, expected);
}

ObjectReader ObjectReader::Child(std::string_view key) const {
  return ObjectReader(Required(key, "an object"), PathOf(key), file_);
}

ObjectReader ObjectReader::Element(std::string_view list, const JsonValue& item,
                                   std::size_t index) const {
  return ObjectReader(item, fmt::format("{}[{}]", PathOf(list), index), file_);
}

void ObjectReader::Fail(std::string_view key, std::string_view found,
                        std::string_view expected) const {
  const std::string path = PathOf(key);
  const JsonValue* value = Optional(key);
  throw InputError(file_,
                   (path.empty() ? "top level" : path) + (value ? *value : value_).Position(),
                   found, expected);
}

void ObjectReader::Fail(std::string_view key, const JsonValue& found,
                        std::string_view expected) const {
  const std::string path = PathOf(key);
  throw InputError(file_, (path.empty() ? "top level" : path) + found.Position(), found.Shown(),
                   expected);
}

std::string ObjectReader::PathOf(std::string_view key) const {
  if (key.empty()) return path_;
  return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
}

}  // namespace muster
