#include "base/check.h"

#include <cstdlib>

#include "base/say.h"

namespace muster {

void CheckFailed(const char* file, int line, const char* condition, const std::string& values) {
  Say("{}:{}: check failed: {} {}\n", file, line, condition, values);
  std::abort();
}

}  // namespace muster
