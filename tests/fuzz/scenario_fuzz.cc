// Arbitrary text as a scenario: refused with InputError, or the same scenario when it is written
// and read again.

#include <string>

#include "base/check.h"
#include "model/scenario_json.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace muster;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const std::string written = ScenarioToJson(ParseScenario(std::string(text), "scenario.json"));
    MUSTER_CHECK(ScenarioToJson(ParseScenario(written, "written.json")) == written);
  } catch (const InputError&) {
  }
  return 0;
}
