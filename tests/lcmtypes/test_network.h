#pragma once

#include <gtest/gtest.h>

#include "tools/host/network_namespace.h"

namespace muster {

/// The network of this test program, entered before the first test: private where the kernel allows
/// it, so that tests that run side by side never hear each other.
const tools::Network& TestNetwork();

}  // namespace muster

#define MUSTER_NEEDS_MULTICAST()                                             \
  if (::muster::TestNetwork().kind == ::muster::tools::Network::Kind::kNone) \
  GTEST_SKIP() << ::muster::TestNetwork().detail
