#include <cmath>

#include "protocol/convert.h"
#include "tools/explain/story.h"
#include "tools/explain/words.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;
using scheduler::AgentAnswer;
using scheduler::AgentCondition;
using scheduler::Fate;
using scheduler::Forcing;
using scheduler::Option;
using scheduler::PairLook;
using scheduler::PairPlan;
using scheduler::PlaceLook;
using scheduler::RangeNeed;
using scheduler::TaskAnswer;
using scheduler::TaskVerdict;

/// Seconds of the mission; null: not known.
Json Seconds(TimeUs t) { return t == kNever ? Json() : Json(ToSeconds(t)); }

/// [fact(item), ...]
template <class T, class Fact>
Json ListOf(const std::vector<T>& items, Fact fact) {
  Json list = Json::array();
  for (const T& item : items) list.push_back(fact(item));
  return list;
}

/// fact(item); null: there is none.
template <class T, class Fact>
Json IfAny(const std::optional<T>& item, Fact fact) {
  return item ? Json(fact(*item)) : Json();
}

/// With the keys of report.json.
Json CommandJson(const Action& action) { return ActionJson(ToWire(action)); }
std::size_t TasksDone(std::size_t n) { return n; }

Json NeedJson(const RangeNeed& need) {
  Json json = {{"uav", need.uav.value},     {"range_m", need.range_m},
               {"needs_m", need.needs_m()}, {"way_m", need.way_m},
               {"sensing_m", need.cost_m},  {"to_charge_m", need.to_charge_m}};
  if (need.free_us) json["free_s"] = Seconds(*need.free_us);
  return json;
}

Json FactJson(const PairLook& pair, bool charging) {
  Json json = {{"uav", pair.uav.value},
               {charging ? "vehicle" : "worker", pair.partner},
               {"end_s", Seconds(pair.end_us)},
               {"latest_s", Seconds(pair.latest_us)}};
  if (pair.partner_way) {
    json["partner_by_road_m"] = pair.partner_way->ground_m;
    json["partner_straight_m"] = pair.partner_way->straight_m;
  }
  if (pair.obstacle == scheduler::Obstacle::kNone) {
    json["weight"] = pair.weight;
  } else {
    json["obstacle"] = ToString(pair.obstacle);
  }
  if (pair.uav_free_us) json["uav_free_s"] = Seconds(*pair.uav_free_us);
  if (pair.partner_free_us) {
    json[charging ? "vehicle_free_s" : "worker_free_s"] = Seconds(*pair.partner_free_us);
  }
  if (pair.window_of) {
    json["window_of"] =
        *pair.window_of == AgentKind::kUav
            ? AgentName(AgentKind::kUav, pair.uav.value)
            : AgentName(charging ? AgentKind::kVehicle : AgentKind::kWorker, pair.partner);
  }
  return json;
}

Json FactJson(const PlaceLook& look) {
  Json json = {{"obstacle", ToString(look.obstacle)},
               {"idle_uavs", look.idle_uavs},
               {"busy_uavs", look.busy_uavs},
               {"not_ready_uavs", look.unready_uavs},
               {look.charging ? "idle_vehicles" : "idle_workers", look.idle_partners},
               {look.charging ? "busy_vehicles" : "busy_workers", look.busy_partners},
               {look.charging ? "not_ready_vehicles" : "not_ready_workers", look.unready_partners},
               {"uavs_in_range", look.uavs_in_range},
               {"pairs_in_range", look.pairs},
               {"pairs_feasible", look.pairs_feasible},
               {"pairs_after_online_window", look.pairs_after_window},
               {"pairs_after_time_limit", look.pairs_after_limit}};
  if (look.pairs_after_expiry > 0) json["pairs_after_expiry"] = look.pairs_after_expiry;
  if (look.soon_decisions > 0) {
    json["soon_decisions"] = look.soon_decisions;
    json["soon_uavs"] = look.soon_uavs;
    json[look.charging ? "soon_vehicles" : "soon_workers"] = look.soon_partners;
  }
  json["nearest_by_range"] = IfAny(look.nearest_range, NeedJson);
  json["nearest_by_time"] =
      IfAny(look.nearest_time, [&](const PairLook& pair) { return FactJson(pair, look.charging); });
  if (look.closure) {
    json["closure"] = {{"order", look.closure->order},
                       {"name", look.closure->name},
                       {"since_s", Seconds(look.closure->since_us)}};
  }
  return json;
}

Json FactJson(const AgentAnswer::Blocked& group) {
  return {{"obstacle", ToString(group.obstacle)},
          {group.charging ? "charging_points" : "tasks", group.places},
          {group.charging ? "nearest_charge" : "nearest_task", group.nearest.site},
          {"nearest", FactJson(group.nearest)}};
}

Json FactJson(const Activity& activity) {
  return {{"uav", activity.uav.value},
          {"worker", activity.partner},
          {"start_s", Seconds(activity.start_us)},
          {"end_s", Seconds(activity.end_us)}};
}

Json FactJson(const AgentState& state) {
  return {{"kind", static_cast<int>(state.action)},
          {"symbol", ToString(state.action)},
          {"target", state.site()},
          {"partner", state.partner},
          {"since_decision", state.decision},
          {"until_s", Seconds(state.busy_until_us)}};
}

Json PlanJson(const PairPlan& pair) {
  return {
      {pair.charging ? "charge" : "task", pair.site},
      {"uav", pair.uav.value},
      {pair.charging ? "vehicle" : "worker", pair.partner},
      {"uav_free_s", IfAny(pair.uav_free_us, Seconds)},
      {pair.charging ? "vehicle_free_s" : "worker_free_s", IfAny(pair.partner_free_us, Seconds)},
      {"worth", pair.worth},
      {"end_s", Seconds(pair.end_us)},
      {"matching", pair.second ? 2 : 1}};
}

Json ForcingJson(const Forcing& forcing, Terms terms) {
  Json json = {{"cost", forcing.cost},
               {"exact", forcing.exact},
               {"cost_between", {forcing.cost_low, forcing.cost_high}}};
  const Json displaced = ListOf(forcing.displaced, [](TaskId task) { return task.value; });
  if (terms == Terms::kPaper) {
    json["weight"] = forcing.with.weight;
    json["bound"] = forcing.with.bound;
    json["pair"] = IfAny(forcing.pair, CommandJson);
    json["tasks_displaced"] = displaced;
  } else {
    json["pair"] = IfAny(forcing.plan, PlanJson);
    json["tasks_displaced"] = displaced;
    json["forecast_done"] = IfAny(forcing.forecast_done, TasksDone);
  }
  return json;
}

Json OptionJson(const Option& option, Terms terms) {
  Json json = {{option.charging ? "charge" : "task", option.site},
               {"pair", FactJson(option.pair, option.charging)}};
  if (terms == Terms::kPaper) {
    json["uav_did"] = CommandJson(option.uav_did);
    json[option.charging ? "vehicle_did" : "worker_did"] = CommandJson(option.partner_did);
    json["place_taken_by"] = IfAny(option.site_holder, CommandJson);
  } else {
    json["outbid_by"] = ListOf(option.rivals, PlanJson);
  }
  return json;
}

Json FateJson(const std::pair<PairPlan, Fate>& planned) {
  const auto& [pair, fate] = planned;
  Json json = {{"plan", PlanJson(pair)}, {"outcome", ToString(fate.kind)}};
  json["decision"] = fate.decision < 0 ? Json() : Json(fate.decision);
  json["still_planned_in"] = fate.kept;
  if (fate.member_kind) json["member"] = AgentName(*fate.member_kind, fate.member);
  if (fate.taken_by) json["taken_by"] = CommandJson(*fate.taken_by);
  if (!fate.rivals.empty()) json["outbid_by"] = ListOf(fate.rivals, PlanJson);
  if (fate.look) json["pairs"] = FactJson(*fate.look);
  return json;
}

/// How the decision came about, in horizon's terms.
template <class Answer>
void AddHow(const Chapter<Answer>& chapter, Json* json) {
  if (!chapter.how) return;
  (*json)["made_again"] = chapter.how->again;
  (*json)["settings"] = chapter.settings;
  if (chapter.how->follow) {
    (*json)["variant"] = chapter.how->variant + 1;
    (*json)["variants"] = chapter.how->variants;
    (*json)["draws"] = chapter.how->draws;
    (*json)["tasks_drawn"] = chapter.how->tasks_drawn;
  }
  (*json)["planned"] = ListOf(chapter.fates, FateJson);
}

/// What the matching is worth, in horizon's terms.
template <class Answer>
void AddWorth(const Chapter<Answer>& chapter, Json* json) {
  if (!chapter.how || chapter.answer.options.empty()) return;
  (*json)["worth"] = chapter.quality.best.weight;
  (*json)["bound"] = chapter.quality.best.bound;
  (*json)["forecast_done"] = IfAny(chapter.quality.forecast_done, TasksDone);
}

void AddAnswer(const Chapter<TaskAnswer>& chapter, Terms terms, Json* json) {
  const TaskAnswer& answer = chapter.answer;
  (*json)["verdict"] = ToString(answer.verdict);
  if (answer.verdict == TaskVerdict::kDone || answer.verdict == TaskVerdict::kUnreported ||
      answer.verdict == TaskVerdict::kExpired) {
    return;
  }
  if (answer.verdict == TaskVerdict::kUnderWay) {
    if (answer.activity) (*json)["pair"] = FactJson(*answer.activity);
    return;
  }
  AddHow(chapter, json);
  (*json)["commanded"] = ListOf(answer.commanded, CommandJson);
  (*json)["pairs"] = FactJson(answer.look);
  if (answer.options.empty()) return;
  (*json)["options"] =
      ListOf(answer.options, [terms](const Option& option) { return OptionJson(option, terms); });
  if (terms == Terms::kPaper) (*json)["lost_to"] = ListOf(answer.rivals, CommandJson);
  (*json)["forcing"] = IfAny(
      answer.forcing, [terms](const Forcing& forcing) { return ForcingJson(forcing, terms); });
  AddWorth(chapter, json);
}

void AddAnswer(const Chapter<AgentAnswer>& chapter, Terms terms, Json* json) {
  const AgentAnswer& answer = chapter.answer;
  (*json)["condition"] = ToString(answer.condition);
  if (answer.condition == AgentCondition::kBusy && answer.state) {
    (*json)["under_way"] = FactJson(*answer.state);
    if (terms == Terms::kHorizon) (*json)["free_s"] = IfAny(answer.free_us, Seconds);
  }
  if (answer.condition != AgentCondition::kIdle && !answer.free_us) return;
  AddHow(chapter, json);
  if (answer.did) (*json)["did"] = CommandJson(*answer.did);
  if (terms == Terms::kHorizon) (*json)["matched"] = ListOf(answer.plans, PlanJson);
  (*json)["places_feasible"] = answer.places_feasible;
  (*json)["options"] = ListOf(answer.options, [terms](const Option& option) {
    Json one = OptionJson(option, terms);
    one["forcing"] = IfAny(option.forcing,
                           [terms](const Forcing& forcing) { return ForcingJson(forcing, terms); });
    return one;
  });
  (*json)["blocked"] =
      ListOf(answer.blocked, [](const AgentAnswer::Blocked& group) { return FactJson(group); });
  AddWorth(chapter, json);
}

Json EventJson(const event_t& event) {
  return {{"at_s", ToSeconds(event.at_us)},
          {"kind", Spaced(ToString<EventKind>(event.kind))},
          {"uav", event.uav_id},
          {"worker", event.worker_id},
          {"vehicle", event.vehicle_id},
          {"task", event.task_id},
          {"charge", event.charge_id}};
}

template <class Answer>
void AddDirectives(const Chapter<Answer>& chapter, Json* json) {
  if (chapter.directives.empty()) return;
  constexpr std::string_view kStates[] = {"kept", "waits", "not kept", "over"};
  (*json)["directives"] = ListOf(chapter.directives, [&](const Directed& directed) {
    return Json{{"order", directed.directive.order},
                {"issuer", directed.directive.issuer},
                {"what", ToString(directed.directive)},
                {"state", kStates[static_cast<std::size_t>(directed.state)]},
                {"why", directed.why},
                {"commanded", ListOf(directed.sent, CommandJson)}};
  });
  if (!chapter.with_and_without) return;
  (*json)["weight_with"] = chapter.with_and_without->first;
  (*json)["weight_without"] = chapter.with_and_without->second;
}

template <class Answer>
Json ChapterJson(const Chapter<Answer>& chapter, Terms terms) {
  Json json = {{"decision", chapter.decision}, {"at_s", ToSeconds(chapter.at_us)}};
  json["policy"] = chapter.scheduled ? Json(chapter.policy) : Json();
  json["in_force"] = chapter.in_force && chapter.scheduled;
  if (!chapter.missing.empty()) {
    json["missing"] = chapter.missing;
  } else {
    if (terms == Terms::kPaper && !chapter.directed) {
      json["weight"] = chapter.quality.weight;
      json["best_weight"] = chapter.quality.best.weight;
      json["best_bound"] = chapter.quality.best.bound;
      json["own_weights"] = chapter.quality.own_weights;
    }
    AddDirectives(chapter, &json);
    if (chapter.directed) {
      json["verdict"] = "directed";
    } else {
      AddAnswer(chapter, terms, &json);
    }
  }
  if (!chapter.withheld.empty()) json["withheld"] = ListOf(chapter.withheld, EventJson);
  json["events"] = ListOf(chapter.events, EventJson);
  return json;
}

template <class Story>
Json HeadOf(const Story& story) {
  return {{"version", 2},
          {"terms", ToString(story.terms)},
          {"unit", story.terms == Terms::kHorizon ? "tasks" : "weight"},
          {"policy", story.policy.empty() ? Json() : Json(story.policy)}};
}

template <class Story>
void AddDecisions(const Story& story, Json* json) {
  (*json)["decisions"] = ListOf(
      story.chapters, [&](const auto& chapter) { return ChapterJson(chapter, story.terms); });
}

}  // namespace

Json ToJson(const TaskStory& story) {
  Json json = HeadOf(story);
  json["task"] = story.task.value;
  json["x_m"] = story.spec.at.x_m;
  json["y_m"] = story.spec.at.y_m;
  json["sensing_m"] = story.spec.cost_m;
  json["to_charge_m"] = std::isfinite(story.to_charge_m) ? Json(story.to_charge_m) : Json();
  json["status"] = ToString(story.last_status);
  json["done_s"] = story.done ? Json(ToSeconds(story.done->at_us)) : Json();
  AddDecisions(story, &json);
  return json;
}

Json ToJson(const AgentStory& story) {
  Json json = HeadOf(story);
  json["agent"] = AgentName(story.kind, story.id);
  json["online_from_s"] = ToSeconds(story.spec.online_from_us);
  json["online_until_s"] = ToSeconds(story.spec.online_until_us);
  AddDecisions(story, &json);
  return json;
}

}  // namespace muster::tools
