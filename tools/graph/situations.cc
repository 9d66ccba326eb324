#include "tools/graph/situations.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>

#include "base/check.h"
#include "lcmtypes/bus/event_log.h"
#include "model/scenario_json.h"
#include "protocol/process.h"
#include "simulation/simulator.h"
#include "tools/files/log_files.h"

namespace muster::tools {

void SituationRecorder::Add(const Packet& packet) {
  reader_.Add(packet, [&](const Message& message, const Packet&) {
    if (!scenario_) Begin();
    const auto take = [&](const auto& of_tick) {
      if (of_tick.tick > scenario_->rules.last_tick()) return;
      if (reader_.orders().complete(of_tick.tick)) return Take(message);
      waiting_[of_tick.tick].push_back(message);
    };
    Handle(
        message, [&](const agent_states_t& m) { take(m); },
        [&](const world_state_t& m) { take(m); }, [&](const rulings_t& m) { take(m); });
  });
  while (!waiting_.empty() && reader_.orders().complete(waiting_.begin()->first)) {
    for (const Message& message : waiting_.begin()->second) Take(message);
    waiting_.erase(waiting_.begin());
  }
}

void SituationRecorder::Take(const Message& message) {
  const auto take = [&](const auto& of_tick) {
    if (scenario_->rules.DecisionAt(of_tick.tick) < 0) return;
    // Impossible messages are left out, as the scheduler leaves them out.
    static_cast<void>(FusionAt(of_tick.tick).Take(of_tick));
  };
  Handle(
      message, [&](const agent_states_t& m) { take(m); }, [&](const world_state_t& m) { take(m); },
      [&](const rulings_t& m) { take(m); });
}

void SituationRecorder::Begin() {
  scenario_ = reader_.scenario();
  const Rules& rules = scenario_->rules;
  for (TimeUs t = 0; t < rules.limit_us; t += rules.interval_us) FusionAt(rules.TickOf(t));
}

scheduler::Fusion& SituationRecorder::FusionAt(std::int64_t tick) {
  const auto [fusion, is_new] = fusions_.try_emplace(tick, scenario_);
  if (is_new) fusion->second.Start(tick, scenario_->rules.TimeOf(tick), -1);
  return fusion->second;
}

std::vector<scheduler::Situation> SituationRecorder::Situations(std::vector<double>* fuse_s) {
  std::vector<scheduler::Situation> situations;
  for (auto& [tick, fusion] : fusions_) {
    const OrderBook& orders = reader_.orders();
    if (!fusion.complete() || !orders.complete(tick)) continue;
    const auto start = std::chrono::steady_clock::now();
    situations.push_back(fusion.Fuse(orders));
    situations.back().decision = orders.scenario()->rules.DecisionAt(tick);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    if (fuse_s != nullptr) fuse_s->push_back(took.count());
  }
  return situations;
}

std::vector<scheduler::Situation> SituationsOf(const std::string& run_or_scenario,
                                               const std::string& policy) {
  SituationRecorder recorder;
  const std::filesystem::path path(run_or_scenario);
  if (std::filesystem::is_directory(path) || path.extension() != ".json") {
    for (const std::string& file : LogFilesOf(run_or_scenario)) {
      const auto reader = OpenLog(file, EventLogReader::Tail::kFinal);
      while (const auto event = reader->Next()) recorder.Add(event->packet);
    }
    if (recorder.n_decisions() == 0) {
      throw InputError(fmt::format("{}: the log holds no scenario", run_or_scenario));
    }
  } else {
    Simulate(TextOf(LoadScenario(run_or_scenario)), policy,
             [&](const Packet& packet) { recorder.Add(packet); });
  }
  return recorder.Situations();
}

scheduler::Situation SituationOf(const std::string& run_or_scenario, const std::string& policy,
                                 std::int32_t decision) {
  const auto situations = SituationsOf(run_or_scenario, policy);
  for (const scheduler::Situation& situation : situations) {
    if (situation.decision == decision) return situation;
  }
  throw InputError(run_or_scenario, "--decision", fmt::to_string(decision),
                   situations.empty()
                       ? std::string("a mission with a complete decision")
                       : fmt::format("a complete decision, {} to {}", situations.front().decision,
                                     situations.back().decision));
}

}  // namespace muster::tools
