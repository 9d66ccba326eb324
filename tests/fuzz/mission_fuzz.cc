// Arbitrary packets to every process of a mission that is under way, half-way to a world that
// starts again: no crash, no broken invariant, and whoever stops says why.

#include "base/check.h"
#include "tests/fuzz/fuzz_mission.h"
#include "tests/simulation/archivist.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace muster;
  static const std::string json = fuzz::SmallMission();
  static const Scenario scenario = ParseScenario(json, "scenario");
  auto processes = fuzz::StartSmallMission(json);
  processes.push_back(std::make_unique<tools::testing::Archivist>(scenario, true));
  Now now;
  std::vector<Packet> said;
  const auto step_all = [&](const std::vector<Packet>& arrived, TimeUs longer_us) {
    std::vector<Packet> answers;
    for (const auto& process : processes) process->Step(arrived, now, &answers);
    now.monotonic_us += longer_us;
    said = std::move(answers);
  };
  try {
    step_all({}, 5'000);
    std::vector<Packet> packets = fuzz::ParsePackets(data, size);
    for (std::size_t i = 0; i < packets.size(); ++i) {
      if (i == packets.size() / 2) {
        world::WorldOptions options;
        options.goes_on = true;
        options.lost_after_us = kSecondUs / 10;
        processes.front() =
            std::make_unique<world::WorldProcess>(Identity{1, "world", 1}, 0, json, options);
      }
      said.push_back(std::move(packets[i]));
      step_all(said, 5'000);
    }
    // Long enough for the archive to answer.
    for (int i = 0; i < 20; ++i) step_all(said, 150'000);
  } catch (const InputError&) {
    // "worker 0 is reported by two processes": a mission that cannot be.
  }
  return 0;
}
