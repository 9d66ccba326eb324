#include "tools/audit/report_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>

#include "tools/audit/values.h"

namespace muster::tools::audit {
namespace {

using nlohmann::json;

template <class T>
void Put(std::string* bytes, T value) {
  static_assert(std::endian::native == std::endian::little);
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes->append(raw, sizeof value);
}

/// As tools/record/digest.h describes it.
std::string DigestOf(const Facts& facts, const std::vector<std::int64_t>& done_us) {
  std::string bytes = "muster digest 1\n";
  for (const auto& [index, schedule] : facts.schedules) {
    bytes += 'D';
    Put(&bytes, std::int32_t{index});
    Put(&bytes, static_cast<std::int32_t>(schedule.actions.size()));
    std::vector<action_t> actions = schedule.actions;
    const auto key = [](const action_t& a) {
      return std::tuple(a.kind, a.uav_id, a.worker_id, a.vehicle_id, a.task_id, a.charge_id);
    };
    std::sort(actions.begin(), actions.end(),
              [&](const action_t& a, const action_t& b) { return key(a) < key(b); });
    for (const action_t& a : actions) {
      Put(&bytes, a.kind);
      for (const std::int32_t id : {a.uav_id, a.worker_id, a.vehicle_id, a.task_id, a.charge_id}) {
        Put(&bytes, id);
      }
      for (const double value : {a.x_m, a.y_m, a.weight}) Put(&bytes, value);
    }
  }
  std::set<EventKey> outcomes;
  for (const event_t& event : facts.events) {
    if (IsOutcome(static_cast<EventKind>(event.kind))) outcomes.insert(KeyOf(event));
  }
  for (const auto& [at, kind, uav, worker, vehicle, task, charge] : outcomes) {
    bytes += 'E';
    Put(&bytes, std::int64_t{at});
    Put(&bytes, static_cast<std::int8_t>(kind));
    for (const std::int32_t id : {uav, worker, vehicle, task, charge}) Put(&bytes, id);
  }
  for (std::size_t x = 0; x < facts.task_status.size(); ++x) {
    bytes += 'T';
    Put(&bytes, facts.task_status[x]);
    Put(&bytes, done_us[x]);
  }
  for (const double range : facts.final_range_m) {
    bytes += 'U';
    Put(&bytes, range);
  }
  return Sha256Of(bytes);
}

class Comparison {
 public:
  Comparison(const json& report, const Facts& facts) : report_(report), facts_(facts) {}

  std::vector<Violation> Run() {
    Exact("version", 1);
    Exact("seed", facts_.seed);
    Exact("scenario/sha256", facts_.sha256);
    Exact("log/complete", true);
    Exact("log/messages", facts_.messages);
    CompareOutcomes();
    CompareDecisions();
    return std::move(violations_);
  }

 private:
  void Differ(std::int64_t at_us, const std::string& key, const std::string& said,
              const std::string& shown) {
    violations_.push_back(
        {at_us, "report",
         fmt::format("{}: report.json says {}, the log shows {}", key, said, shown)});
  }

  const json* Find(const std::string& path) const {
    const json::json_pointer pointer("/" + path);
    return report_.contains(pointer) ? &report_.at(pointer) : nullptr;
  }

  void Exact(const std::string& path, const json& expected, std::int64_t at_us = 0) {
    const json* found = Find(path);
    if (found != nullptr && *found == expected) return;
    Differ(at_us, path, found == nullptr ? "nothing" : found->dump(), expected.dump());
  }

  void Near(const std::string& path, double expected) {
    const json* found = Find(path);
    if (found != nullptr && found->is_number() &&
        std::abs(found->get<double>() - expected) <= 1e-6 * std::max(1.0, std::abs(expected))) {
      return;
    }
    Differ(0, path, found == nullptr ? "nothing" : found->dump(), fmt::format("{}", expected));
  }

  void CompareOutcomes() {
    const std::size_t total = facts_.task_status.size();
    const auto done =
        std::count(facts_.task_status.begin(), facts_.task_status.end(), TaskStatus::kDone);
    Exact("tasks_total", total);
    Exact("tasks_done", done);
    Near("completion_rate",
         total == 0 ? 0.0 : static_cast<double>(done) / static_cast<double>(total));
    std::vector<std::int64_t> done_us(total, -1);
    std::map<int, std::int64_t> counts;
    for (const event_t& event : facts_.events) {
      ++counts[event.kind];
      const auto x = static_cast<std::size_t>(event.task_id);
      if (event.kind != EventKind::kSensingDone || event.task_id < 0 || x >= total ||
          done_us[x] >= 0)
        continue;
      done_us[x] = event.at_us;
      const std::string task = fmt::format("tasks/{}/", x);
      Exact(task + "status", "done", event.at_us);
      Exact(task + "done_s", ToSeconds(event.at_us), event.at_us);
      Exact(task + "uav", event.uav_id, event.at_us);
      Exact(task + "worker", event.worker_id, event.at_us);
    }
    for (std::size_t x = 0; x < total; ++x) {
      if (done_us[x] >= 0) continue;
      const std::string key = fmt::format("tasks/{}/status", x);
      const json* status = Find(key);
      if (status != nullptr && *status == "done") Differ(0, key, "done", "that it was not");
    }
    for (int kind = 0; IsWord<EventKind>(kind); ++kind) {
      const auto word = static_cast<EventKind>(kind);
      if (!IsOutcome(word) || (IsSpecial(word) && counts[kind] == 0)) continue;
      Exact(fmt::format("events/{}", ToString(word)), counts[kind]);
    }
    Exact("charges", counts[NumberOf(EventKind::kChargingDone)]);
    double flown = 0;
    for (std::size_t id = 0; id < facts_.flown_m.size(); ++id) {
      flown += facts_.flown_m[id];
      Near(fmt::format("uavs/{}/flown_m", id), facts_.flown_m[id]);
      Exact(fmt::format("uavs/{}/range_left_m", id), facts_.final_range_m[id]);
    }
    Near("flown_m", flown);
    Exact("digest", DigestOf(facts_, done_us));
  }

  static json Number(double value) { return std::isfinite(value) ? json(value) : json(); }

  void CompareDecisions() {
    const json* list = Find("decisions");
    const std::size_t n = list != nullptr && list->is_array() ? list->size() : 0;
    if (n != facts_.schedules.size()) {
      Differ(0, "decisions", fmt::format("{} decisions", n),
             fmt::format("{}", facts_.schedules.size()));
      return;
    }
    std::size_t i = 0;
    for (const auto& [index, schedule] : facts_.schedules) {
      const std::int64_t at = facts_.decided_us.at(index);
      const std::string key = fmt::format("decisions/{}", i++);
      Exact(key + "/index", index, at);
      Exact(key + "/sim_s", ToSeconds(at), at);
      Exact(key + "/policy", schedule.policy, at);
      Exact(key + "/weight", Number(schedule.weight), at);
      Exact(key + "/bound", Number(schedule.bound), at);
      Exact(key + "/candidates", schedule.candidates, at);
      const json* actions = Find(key + "/actions");
      if (actions == nullptr || actions->size() != schedule.actions.size()) {
        Differ(at, key + "/actions",
               actions == nullptr ? "nothing" : fmt::format("{} actions", actions->size()),
               fmt::format("{}", schedule.actions.size()));
        continue;
      }
      for (std::size_t j = 0; j < schedule.actions.size(); ++j) {
        const action_t& a = schedule.actions[j];
        const std::string row = fmt::format("{}/actions/{}", key, j);
        Exact(row + "/kind", a.kind, at);
        Exact(row + "/uav", a.uav_id, at);
        Exact(row + "/worker", a.worker_id, at);
        Exact(row + "/vehicle", a.vehicle_id, at);
        Exact(row + "/task", a.task_id, at);
        Exact(row + "/charge", a.charge_id, at);
        Exact(row + "/weight", Number(a.weight), at);
      }
    }
  }

  const json& report_;
  const Facts& facts_;
  std::vector<Violation> violations_;
};

}  // namespace

std::vector<Violation> CheckReportFile(const json& report, const Facts& facts) {
  return Comparison(report, facts).Run();
}

}  // namespace muster::tools::audit
