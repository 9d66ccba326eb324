// Arbitrary text as a fault plan and as a --fault flag: refused with InputError, or a plan whose
// faults can be published.

#include "base/check.h"
#include "lcmtypes/bus/codec.h"
#include "tests/fuzz/fuzz_mission.h"
#include "tools/faults/fault_plan.h"

namespace {

void Check(muster::tools::FaultPlan plan) {
  using namespace muster;
  static const Scenario scenario = ParseScenario(fuzz::SmallMission(), "scenario.json");
  tools::CheckFaultPlan(&plan, {"world", "uav", "worker", "vehicle", "scheduler"}, scenario, false);
  for (const tools::PlannedFault& fault : plan) {
    fault_t message = tools::ToWire(fault);
    message.header.sender = "launcher";
    MUSTER_CHECK(DecodeValid<fault_t>(Encode(message)), "{}", fault.where);
  }
  tools::WorldOptionsOf(plan);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(data, data + size);
  try {
    Check(muster::tools::ParseFaultPlan(text, "plan.json"));
  } catch (const muster::InputError&) {
  }
  try {
    Check({muster::tools::ParseFaultFlag(text, 0)});
  } catch (const muster::InputError&) {
  }
  return 0;
}
