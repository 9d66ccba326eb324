// Arbitrary packets to every process of a mission that is under way: no crash, no broken invariant,
// and whoever stops says why.

#include "tests/fuzz/fuzz_mission.h"
#include "world/model/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace muster;
  static const std::string json = fuzz::SmallMission();
  auto processes = fuzz::StartSmallMission(json);
  Now now;
  std::vector<Packet> said;
  const auto step_all = [&](const std::vector<Packet>& arrived) {
    std::vector<Packet> answers;
    for (const auto& process : processes) process->Step(arrived, now, &answers);
    now.monotonic_us += 5'000;
    said = std::move(answers);
  };
  try {
    step_all({});
    for (Packet& packet : fuzz::ParsePackets(data, size)) {
      said.push_back(std::move(packet));
      step_all(said);
    }
    for (int i = 0; i < 20; ++i) step_all(said);
  } catch (const InputError&) {
    // "worker 0 is reported by two processes": a mission that cannot be.
  }
  return 0;
}
