#include "base/json_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/check.h"

namespace muster {
namespace {

/// Our files nest four deep. The limit keeps garbage from exhausting the stack.
constexpr std::size_t kMaxDepth = 16;

/// Receives the events of nlohmann's parser and builds the tree.
class TreeBuilder : public nlohmann::json_sax<nlohmann::json> {
 public:
  TreeBuilder(std::string_view json, std::string_view file) : json_(json), file_(file) {}

  JsonValue Take() { return std::move(root_); }

  bool null() override {
    Place(JsonValue::Type::kNull);
    return true;
  }
  bool boolean(bool value) override {
    Place(JsonValue::Type::kBoolean)->boolean = value;
    return true;
  }
  bool number_integer(number_integer_t value) override {
    Place(JsonValue::Type::kNumber)->text = fmt::to_string(value);
    return true;
  }
  bool number_unsigned(number_unsigned_t value) override {
    Place(JsonValue::Type::kNumber)->text = fmt::to_string(value);
    return true;
  }
  bool number_float(number_float_t, const string_t& text) override {
    Place(JsonValue::Type::kNumber)->text = text;
    return true;
  }
  bool string(string_t& value) override {
    Place(JsonValue::Type::kString)->text = std::move(value);
    return true;
  }
  bool binary(binary_t&) override { return false; }  // text has none

  bool start_object(std::size_t) override { return Open(JsonValue::Type::kObject); }
  bool start_array(std::size_t) override { return Open(JsonValue::Type::kArray); }
  bool key(string_t& name) override {
    open_.back()->members.push_back({std::move(name), JsonValue()});
    return true;
  }
  bool end_object() override {
    std::vector<std::string_view> keys;
    keys.reserve(open_.back()->members.size());
    for (const auto& [name, value] : open_.back()->members) keys.push_back(name);
    std::sort(keys.begin(), keys.end());
    const auto twice = std::adjacent_find(keys.begin(), keys.end());
    if (twice != keys.end()) {
      std::string path = Path();
      if (!path.empty()) path += '.';
      throw InputError(file_, path + std::string(*twice), "the key twice", "each key once");
    }
    open_.pop_back();
    return true;
  }
  bool end_array() override {
    open_.pop_back();
    return true;
  }

  bool parse_error(std::size_t position, const std::string& token,
                   const nlohmann::json::exception& error) override {
    const std::string_view read = json_.substr(0, std::min(position, json_.size()));
    const auto line = 1 + std::count(read.begin(), read.end(), '\n');
    const std::size_t newline = read.rfind('\n');
    const std::size_t column = newline == read.npos ? read.size() : read.size() - newline - 1;
    // "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error ..."
    std::string why = error.what();
    if (const std::size_t at = why.find("] "); at != why.npos) why.erase(0, at + 2);
    if (const std::size_t at = why.find(": "); why.starts_with("parse error") && at != why.npos) {
      why.erase(0, at + 2);
    }
    // The token may be as long as the file; its end is where the error is.
    const std::string found = token.size() > 40 ? "..." + token.substr(token.size() - 40) : token;
    if (const std::size_t at = why.find("; last read: '"); at != why.npos) {
      const std::size_t next = why.rfind("; expected ");
      why.erase(at, next == why.npos || next < at ? why.npos : next - at);
    }
    if (why.size() > 160) why = why.substr(0, 160) + "...";
    throw InputError(file_, fmt::format("line {}, column {}", line, column), "'" + found + "'",
                     fmt::format("valid JSON ({})", why));
  }

 private:
  JsonValue* Place(JsonValue::Type type) {
    JsonValue* value = &root_;
    if (!open_.empty()) {
      JsonValue* parent = open_.back();
      value = parent->type == JsonValue::Type::kArray ? &parent->items.emplace_back()
                                                      : &parent->members.back().value;
    }
    value->type = type;
    return value;
  }

  bool Open(JsonValue::Type type) {
    if (open_.size() == kMaxDepth) {
      throw InputError(file_, Path(), "objects and arrays nested deeper",
                       fmt::format("at most {} levels", kMaxDepth));
    }
    open_.push_back(Place(type));
    return true;
  }

  /// Key path of the innermost open object or array.
  std::string Path() const {
    std::string path;
    for (std::size_t i = 0; i + 1 < open_.size(); ++i) {
      if (open_[i]->type == JsonValue::Type::kArray) {
        path += fmt::format("[{}]", open_[i]->items.size() - 1);
      } else {
        path += (path.empty() ? "" : ".") + open_[i]->members.back().name;
      }
    }
    return path;
  }

  std::string_view json_;
  std::string_view file_;
  JsonValue root_;
  /// From the root down. A parent's vector grows only while none of its elements is open, so the
  /// pointers hold.
  std::vector<JsonValue*> open_;
};

}  // namespace

const JsonValue* JsonValue::Find(std::string_view key) const {
  for (const auto& [name, value] : members) {
    if (name == key) return &value;
  }
  return nullptr;
}

std::string JsonValue::Shown() const {
  constexpr std::size_t kMost = 40;
  std::string shortened = text.substr(0, kMost);
  if (text.size() > kMost) shortened += "...";
  switch (type) {
    case Type::kNull:
      return "null";
    case Type::kBoolean:
      return boolean ? "true" : "false";
    case Type::kNumber:
      return shortened;
    case Type::kString:
      // dump() escapes what would break the message's one line; a cut may split a UTF-8 sequence.
      return nlohmann::json(shortened).dump(-1, ' ', false,
                                            nlohmann::json::error_handler_t::replace);
    case Type::kArray:
      return fmt::format("an array of {}", items.size());
    case Type::kObject:
      return "an object";
  }
  return "";
}

JsonValue ParseJson(std::string_view json, std::string_view file) {
  TreeBuilder builder(json, file);
  nlohmann::json::sax_parse(json, &builder);
  return builder.Take();
}

}  // namespace muster
