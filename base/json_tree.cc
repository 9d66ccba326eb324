#include "base/json_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/check.h"

namespace muster {
namespace {

/// Our files nest four deep. The limit keeps garbage from exhausting the stack.
constexpr std::size_t kMaxDepth = 16;

/// Reads the text for the parser, and knows how far it has come.
class Cursor {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  Cursor(const char* at, const char** reached) : at_(at), reached_(reached) {}
  reference operator*() const { return *at_; }
  Cursor& operator++() {
    *reached_ = ++at_;
    return *this;
  }
  bool operator==(const Cursor& other) const { return at_ == other.at_; }
  bool operator!=(const Cursor& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  const char** reached_;
};

/// Receives the events of nlohmann's parser and builds the tree.
class TreeBuilder : public nlohmann::json_sax<nlohmann::json> {
 public:
  TreeBuilder(std::string_view json, std::string_view file)
      : json_(json),
        file_(file),
        reached_(json.data()),
        counted_(json.data()),
        has_lines_(json.substr(0, json.find_last_not_of("\r\n") + 1).find('\n') != json.npos) {}

  void Parse() {
    nlohmann::json::sax_parse(Cursor(json_.data(), &reached_),
                              Cursor(json_.data() + json_.size(), &reached_), this);
  }

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
    if (has_lines_) Locate(value);
    return value;
  }

  /// The parser has read the value's last character, or the first one of what it has parts of; of a
  /// number one more.
  void Locate(JsonValue* value) {
    const char* at = reached_ - 1;
    if (value->type == JsonValue::Type::kNumber && at > json_.data() && !IsOfNumber(*at)) --at;
    const auto is_inside = [&](char c) {
      return value->type == JsonValue::Type::kNumber ? IsOfNumber(c) : c >= 'a' && c <= 'z';
    };
    if (value->type == JsonValue::Type::kString) {
      do {
        --at;
      } while (*at != '"' || IsEscaped(at));
    } else if (value->type != JsonValue::Type::kArray && value->type != JsonValue::Type::kObject) {
      while (at > json_.data() && is_inside(at[-1])) --at;
    }
    for (; counted_ < at; ++counted_) {
      if (*counted_ != '\n') continue;
      ++line_;
      line_begin_ = counted_ + 1;
    }
    value->line = line_;
    value->column = static_cast<std::uint32_t>(at - line_begin_) + 1;
  }
  static bool IsOfNumber(char c) {
    return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.' || c == 'e' || c == 'E';
  }
  bool IsEscaped(const char* quote) const {
    int backslashes = 0;
    for (const char* at = quote; at > json_.data() && at[-1] == '\\'; --at) ++backslashes;
    return backslashes % 2 == 1;
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
  const char* reached_;  ///< how far the parser has read
  const char* counted_;  ///< how far lines are counted
  const char* line_begin_ = json_.data();
  std::uint32_t line_ = 1;
  bool has_lines_;  ///< more than one, so positions help
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

std::string JsonValue::Position() const {
  return line == 0 ? "" : fmt::format(" (line {}, column {})", line, column);
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
      return JsonText(shortened);
    case Type::kArray:
      return fmt::format("an array of {}", items.size());
    case Type::kObject:
      return "an object";
  }
  return "";
}

JsonValue ParseJson(std::string_view json, std::string_view file) {
  TreeBuilder builder(json, file);
  builder.Parse();
  return builder.Take();
}

std::string JsonText(std::string_view text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace muster
