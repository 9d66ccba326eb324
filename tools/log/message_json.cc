#include "tools/log/message_json.h"

#include <cmath>
#include <type_traits>
#include <vector>

#include "muster/fields.h"

namespace muster::tools {
namespace {

using nlohmann::ordered_json;

template <class T>
ordered_json ValueJson(const T& value);

/// A message as an object. A count follows from its array, and raw bytes are left out.
struct ToObject {
  ordered_json json = ordered_json::object();
  template <class T>
  void operator()(const char* name, const T& field) {
    if constexpr (std::is_floating_point_v<T>) {
      if (!std::isfinite(field)) return;
    }
    json[name] = ValueJson(field);
  }
  void Count(const char*, std::int32_t) {}
  template <class T>
  void Array(const char* name, const std::vector<T>& array, std::int32_t) {
    if constexpr (!std::is_same_v<T, std::uint8_t>) json[name] = ValueJson(array);
  }
};

template <class T>
ordered_json ValueJson(const T& value) {
  if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
    return value;
  } else if constexpr (requires { value.begin(); }) {
    ordered_json array = ordered_json::array();
    for (const auto& item : value) array.push_back(ValueJson(item));
    return array;
  } else {
    ToObject object;
    VisitFields(object, value);
    return std::move(object.json);
  }
}

template <class T>
struct SchemaOf;

struct ToProperties {
  ordered_json json = ordered_json::object();
  template <class T>
  void operator()(const char* name, const T&) {
    json[name] = SchemaOf<T>::Get();
  }
  void Count(const char*, std::int32_t) {}
  template <class T>
  void Array(const char* name, const std::vector<T>&, std::int32_t) {
    if constexpr (!std::is_same_v<T, std::uint8_t>) json[name] = SchemaOf<std::vector<T>>::Get();
  }
};

template <class T>
struct SchemaOf {
  static ordered_json Get() {
    if constexpr (std::is_integral_v<T>) {
      return {{"type", "integer"}};
    } else if constexpr (std::is_floating_point_v<T>) {
      return {{"type", "number"}};
    } else {
      ToProperties properties;
      const T any{};
      VisitFields(properties, any);
      return {{"type", "object"}, {"properties", std::move(properties.json)}};
    }
  }
};
template <>
struct SchemaOf<std::string> {
  static ordered_json Get() { return {{"type", "string"}}; }
};
template <class T>
struct SchemaOf<std::vector<T>> {
  static ordered_json Get() { return {{"type", "array"}, {"items", SchemaOf<T>::Get()}}; }
};

}  // namespace

ordered_json MessageJson(const Message& message) {
  return std::visit([](const auto& m) { return ValueJson(m); }, message);
}

ordered_json MessageSchema(const Message& type) {
  return std::visit([](const auto& m) { return SchemaOf<std::decay_t<decltype(m)>>::Get(); }, type);
}

}  // namespace muster::tools
