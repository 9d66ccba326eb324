// Arbitrary text as a solver's answer in each of its forms: refused with InputError, or nodes of
// the graph.

#include <sstream>
#include <string>

#include "base/check.h"
#include "tools/graph/conflict_graph.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace muster;
  constexpr std::int32_t kNodes = 12;
  for (const char* form : {"indicator", "nodes", "mps"}) {
    std::istringstream in(std::string(data, data + size));
    try {
      for (const std::int32_t node : tools::ReadSolution(in, "solution", form, kNodes)) {
        MUSTER_CHECK(0 <= node && node < kNodes, "{}", node);
      }
    } catch (const InputError&) {
    }
  }
  return 0;
}
