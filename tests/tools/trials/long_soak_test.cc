// Thousands of missions under random plans in virtual time. MUSTER_MISSIONS says how many.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <functional>
#include <string>
#include <thread>

#include "tests/tools/trials/air_missions.h"
#include "tests/tools/trials/directed_missions.h"
#include "tests/tools/trials/road_missions.h"
#include "tools/host/worker_pool.h"
#include "tools/trials/campaign.h"

namespace muster::tools {
namespace {

void BreakNoPromise(std::size_t n, const std::function<VirtualMission(std::uint64_t)>& draw) {
  const char* const text = std::getenv("MUSTER_MISSIONS");
  const std::size_t missions = text == nullptr ? n : std::strtoul(text, nullptr, 10);
  const auto failed = [](std::size_t seed, const std::string& why) {
    if (!why.empty()) ADD_FAILURE() << "seed " << seed << "\n" << why;
  };
  RunInProcesses(
      missions, static_cast<int>(std::max(1u, std::thread::hardware_concurrency())),
      [&](std::size_t seed) {
        std::string text_of;
        for (const std::string& finding : FindingsOf(draw(seed))) text_of += finding + "\n";
        return text_of;
      },
      failed, failed);
}

/// Each again: muster faults campaign --missions 1 --seed SEED
TEST(LongSoak, RandomMissionsBreakNoPromise) {
  BreakNoPromise(5000, [](std::uint64_t seed) { return DrawMission({}, seed); });
}

TEST(LongSoak, RandomMissionsByRoadBreakNoPromise) { BreakNoPromise(1000, DrawRoadMission); }

TEST(LongSoak, RandomMissionsWithZonesBreakNoPromise) { BreakNoPromise(1000, DrawAirMission); }

TEST(LongSoak, RandomMissionsWithDirectivesBreakNoPromise) {
  BreakNoPromise(500, DrawDirectedMission);
}

}  // namespace
}  // namespace muster::tools
