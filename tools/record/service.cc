#include "tools/record/service.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace muster::tools {
namespace {

constexpr std::array<const char*, kPriorities> kPriorityNames = {"low", "normal", "high",
                                                                 "emergency"};

template <class Field>
int SumOf(const std::array<Service::Of, kPriorities>& rows, Field field) {
  return std::accumulate(rows.begin(), rows.end(), 0,
                         [&](int sum, const Service::Of& row) { return sum + row.*field; });
}

nlohmann::ordered_json OrNull(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

}  // namespace

int Service::reported() const { return SumOf(by_priority, &Of::reported); }
int Service::done() const { return SumOf(by_priority, &Of::done); }
int Service::on_time() const { return SumOf(by_priority, &Of::on_time); }

double Service::mean_response_s() const {
  return std::accumulate(response_s.begin(), response_s.end(), 0.0) /
         static_cast<double>(response_s.size());
}

double Service::response_quantile_s(double part) const {
  if (response_s.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double rank = std::ceil(part * static_cast<double>(response_s.size()));
  return response_s[static_cast<std::size_t>(std::max(1.0, rank)) - 1];
}

Service ServiceOf(const RunRecord& record, const Scenario& scenario) {
  Service service;
  std::vector<TimeUs> began_us(scenario.tasks.size(), -1), start_us(scenario.tasks.size(), -1);
  for (const event_t& event : record.events()) {
    const auto x = static_cast<std::size_t>(event.task_id);
    if (event.task_id < 0 || x >= scenario.tasks.size()) continue;
    if (event.kind == EventKind::kSensingStarted) began_us[x] = event.at_us;
    if (event.kind == EventKind::kSensingDone && start_us[x] < 0) start_us[x] = began_us[x];
    if (event.kind == EventKind::kTaskExpired) ++service.expired;
  }
  for (std::size_t x = 0; x < scenario.n_tasks(); ++x) {
    const Task& task = scenario.tasks[x];
    if (task.reported_us >= scenario.rules.limit_us) continue;
    Service::Of& row = service.by_priority[static_cast<std::size_t>(task.priority)];
    ++row.reported;
    service.worth_all += WorthOf(task, task.reported_us, scenario.rules);
    if (start_us[x] < 0) continue;
    ++row.done;
    row.on_time += start_us[x] <= task.due_us ? 1 : 0;
    service.worth_done += WorthOf(task, start_us[x], scenario.rules);
    service.response_s.push_back(ToSeconds(start_us[x] - task.reported_us));
  }
  std::sort(service.response_s.begin(), service.response_s.end());
  return service;
}

nlohmann::ordered_json ToJson(const Service& service) {
  nlohmann::ordered_json by_priority = nlohmann::ordered_json::object();
  for (std::size_t p = 0; p < kPriorities; ++p) {
    const Service::Of& row = service.by_priority[p];
    by_priority[kPriorityNames[p]] = {
        {"reported", row.reported}, {"done", row.done}, {"on_time", row.on_time}};
  }
  return {{"worth_done", service.worth_done},
          {"worth_all", service.worth_all},
          {"expired", service.expired},
          {"response_s",
           {{"mean", OrNull(service.mean_response_s())},
            {"median", OrNull(service.response_quantile_s(0.5))},
            {"p90", OrNull(service.response_quantile_s(0.9))}}},
          {"by_priority", std::move(by_priority)}};
}

}  // namespace muster::tools
