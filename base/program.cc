#include "base/program.h"

#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "base/check.h"

namespace muster {

int GuardedMain(const char* program, const std::function<int()>& body) {
  try {
    return body();
  } catch (const InputError& error) {
    fmt::print(stderr, "{}: {}\n", program, error.what());
    return kExitUsage;
  } catch (const SystemError& error) {
    fmt::print(stderr, "{}: {}\n", program, error.what());
    return kExitSystem;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: internal error: {}\n", program, error.what());
    return kExitInternal;
  }
}

}  // namespace muster
