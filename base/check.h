#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <string_view>

namespace muster {

/// A user's input that cannot be used. `main` prints it as one line and exits with code 2.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message) : std::runtime_error(message) {}
  /// "scenario.json: uavs[3].x_km: found -1, expected a number in [0, 30]"
  InputError(std::string_view file, std::string_view key, std::string_view found,
             std::string_view expected)
      : std::runtime_error(
            fmt::format("{}: {}: found {}, expected {}", file, key, found, expected)) {}
};

/// The operating system or the network said no. `main` prints it and exits with code 3.
class SystemError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

[[noreturn]] void CheckFailed(const char* file, int line, const char* condition,
                              const std::string& values);

}  // namespace muster

/// A broken invariant: on in every build, prints the optional fmt-style values, aborts.
#define MUSTER_CHECK(condition, ...)                                                        \
  do {                                                                                      \
    if (!(condition)) {                                                                     \
      ::muster::CheckFailed(__FILE__, __LINE__, #condition, ::fmt::format("" __VA_ARGS__)); \
    }                                                                                       \
  } while (false)
