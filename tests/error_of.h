#pragma once

#include <string>

#include "base/check.h"

namespace muster {

/// What the InputError says that the body throws; "" where it throws none.
template <class Body>
std::string ErrorOf(const Body& body) {
  try {
    body();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace muster
