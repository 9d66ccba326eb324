// Thousands of missions under random plans in virtual time. MUSTER_MISSIONS says how many.
#include <gtest/gtest.h>

#include <cstdlib>
#include <thread>

#include "tools/host/worker_pool.h"
#include "tools/trials/soak.h"

namespace muster::tools {
namespace {

TEST(LongSoak, RandomMissionsBreakNoPromise) {
  const char* const text = std::getenv("MUSTER_MISSIONS");
  const std::size_t missions = text == nullptr ? 5000 : std::strtoul(text, nullptr, 10);
  const auto failed = [](std::size_t i, const std::string& why) {
    if (!why.empty())
      ADD_FAILURE() << "muster faults soak --missions 1 --seed " << i << "\n" << why;
  };
  RunInProcesses(
      missions, static_cast<int>(std::max(1u, std::thread::hardware_concurrency())),
      [](std::size_t i) {
        std::string text_of;
        for (const std::string& finding : FindingsOf(DrawMission({}, i))) text_of += finding + "\n";
        return text_of;
      },
      failed, failed);
}

}  // namespace
}  // namespace muster::tools
