#include "tests/lcmtypes/test_network.h"

namespace muster {
namespace {

tools::Network network;

class EnterNetwork : public ::testing::Environment {
 public:
  void SetUp() override { network = tools::EnterPrivateNetwork(); }
};

const ::testing::Environment* const kEnvironment =
    ::testing::AddGlobalTestEnvironment(new EnterNetwork);

}  // namespace

const tools::Network& TestNetwork() { return network; }

}  // namespace muster
