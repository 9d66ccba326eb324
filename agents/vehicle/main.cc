#include "agents/core/agent_main.h"

int main(int argc, char** argv) {
  return muster::agents::AgentMain(muster::AgentKind::kVehicle, argc, argv);
}
