#pragma once

#include <string>

#include "base/check.h"

namespace muster::tools {

/// What the InputError says that the body throws; "no error" where it throws none.
template <class Body>
std::string ErrorOf(const Body& body) {
  try {
    body();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace muster::tools
