#include <cmath>

#include "protocol/convert.h"
#include "tools/explain/facts_json.h"
#include "tools/explain/horizon_json.h"
#include "tools/explain/story.h"
#include "tools/explain/words.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;
using scheduler::AgentAnswer;
using scheduler::AgentCondition;
using scheduler::Forcing;
using scheduler::Optimum;
using scheduler::Option;
using scheduler::TaskAnswer;
using scheduler::TaskVerdict;

Json ToJson(const std::optional<Forcing>& forcing) {
  if (!forcing) return {};
  Json displaced = Json::array();
  for (const TaskId task : forcing->displaced) displaced.push_back(task.value);
  return {{"cost", forcing->cost},
          {"exact", forcing->exact},
          {"cost_between", {forcing->cost_low, forcing->cost_high}},
          {"weight", forcing->with.weight},
          {"bound", forcing->with.bound},
          {"pair", forcing->pair ? ActionJson(ToWire(*forcing->pair)) : Json()},
          {"tasks_displaced", std::move(displaced)}};
}

Json ToJson(const Option& option) {
  Json json = {
      {option.charging ? "charge" : "task", option.site},
      {"pair", FactJson(option.pair, option.charging)},
      {"uav_did", ActionJson(ToWire(option.uav_did))},
      {option.charging ? "vehicle_did" : "worker_did", ActionJson(ToWire(option.partner_did))}};
  json["place_taken_by"] = option.site_holder ? ActionJson(ToWire(*option.site_holder)) : Json();
  return json;
}

template <class Answer>
Json HeadOf(const Chapter<Answer>& chapter) {
  Json json = {{"decision", chapter.decision}, {"at_s", ToSeconds(chapter.at_us)}};
  json["policy"] = chapter.scheduled ? Json(chapter.policy) : Json();
  json["in_force"] = chapter.in_force && chapter.scheduled;
  if (!chapter.missing.empty()) {
    json["missing"] = chapter.missing;
    return json;
  }
  if (chapter.horizon) return json;
  const Optimum& best = chapter.quality.best;
  json["weight"] = chapter.quality.weight;
  json["best_weight"] = best.weight;
  json["best_bound"] = best.bound;
  json["own_weights"] = chapter.quality.own_weights;
  return json;
}

template <class Answer>
void AddEvents(const Chapter<Answer>& chapter, Json* json) {
  Json events = Json::array();
  for (const event_t& event : chapter.events) {
    events.push_back({{"at_s", ToSeconds(event.at_us)},
                      {"kind", Spaced(ToString<EventKind>(event.kind))},
                      {"uav", event.uav_id},
                      {"worker", event.worker_id},
                      {"vehicle", event.vehicle_id},
                      {"task", event.task_id},
                      {"charge", event.charge_id}});
  }
  (*json)["events"] = std::move(events);
}

void Add(const TaskAnswer& answer, Json* json) {
  (*json)["verdict"] = ToString(answer.verdict);
  if (answer.verdict == TaskVerdict::kDone || answer.verdict == TaskVerdict::kUnreported ||
      answer.verdict == TaskVerdict::kExpired) {
    return;
  }
  if (answer.verdict == TaskVerdict::kUnderWay) {
    if (!answer.activity) return;
    (*json)["pair"] = FactJson(*answer.activity);
    return;
  }
  (*json)["commanded"] = ActionsJson(answer.commanded);
  (*json)["pairs"] = FactJson(answer.look);
  if (answer.verdict != TaskVerdict::kLost) return;
  Json options = Json::array();
  for (const Option& option : answer.options) options.push_back(ToJson(option));
  (*json)["options"] = std::move(options);
  (*json)["lost_to"] = ActionsJson(answer.rivals);
  (*json)["forcing"] = ToJson(answer.forcing);
}

void Add(const AgentAnswer& answer, Json* json) {
  (*json)["condition"] = ToString(answer.condition);
  if (answer.condition == AgentCondition::kBusy && answer.state) {
    (*json)["under_way"] = FactJson(*answer.state);
  }
  if (answer.condition != AgentCondition::kIdle) return;
  (*json)["did"] = ActionJson(ToWire(*answer.did));
  (*json)["places_feasible"] = answer.places_feasible;
  Json options = Json::array();
  for (std::size_t i = 0; i < answer.options.size(); ++i) {
    Json option = ToJson(answer.options[i]);
    option["forcing"] = ToJson(answer.forcings[i]);
    options.push_back(std::move(option));
  }
  (*json)["options"] = std::move(options);
  (*json)["blocked"] = FactJson(answer.blocked);
}

template <class Answer>
Json ChaptersJson(const std::vector<Chapter<Answer>>& chapters) {
  Json list = Json::array();
  for (const auto& chapter : chapters) {
    Json json = HeadOf(chapter);
    if (chapter.horizon) {
      AddHorizon(*chapter.horizon, &json);
    } else if (chapter.missing.empty()) {
      Add(chapter.answer, &json);
    }
    AddEvents(chapter, &json);
    list.push_back(std::move(json));
  }
  return list;
}

/// Of weights, worths and costs.
const char* UnitOf(Terms terms) { return terms == Terms::kHorizon ? "tasks" : "weight"; }

}  // namespace

Json ToJson(const TaskStory& story) {
  return {{"version", 2},
          {"terms", NameOf(story.terms)},
          {"unit", UnitOf(story.terms)},
          {"policy", story.policy.empty() ? Json() : Json(story.policy)},
          {"task", story.task.value},
          {"x_m", story.spec.at.x_m},
          {"y_m", story.spec.at.y_m},
          {"sensing_m", story.spec.cost_m},
          {"to_charge_m", std::isfinite(story.to_charge_m) ? Json(story.to_charge_m) : Json()},
          {"status", ToString(story.last_status)},
          {"done_s", story.done ? Json(ToSeconds(story.done->at_us)) : Json()},
          {"decisions", ChaptersJson(story.chapters)}};
}

Json ToJson(const AgentStory& story) {
  return {{"version", 2},
          {"terms", NameOf(story.terms)},
          {"unit", UnitOf(story.terms)},
          {"policy", story.policy.empty() ? Json() : Json(story.policy)},
          {"agent", AgentName(story.kind, story.id)},
          {"online_from_s", ToSeconds(story.spec.online_from_us)},
          {"online_until_s", ToSeconds(story.spec.online_until_us)},
          {"decisions", ChaptersJson(story.chapters)}};
}

}  // namespace muster::tools
