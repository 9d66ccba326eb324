#include "tools/explain/horizon_json.h"

#include "protocol/convert.h"
#include "tools/explain/facts_json.h"
#include "tools/explain/words.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;
using scheduler::AgentCondition;
using scheduler::Fate;
using scheduler::HorizonForcing;
using scheduler::HorizonOption;
using scheduler::HorizonQuality;
using scheduler::HorizonVerdict;
using scheduler::PairPlan;

Json PlanJson(const PairPlan& pair) {
  return {{pair.charging ? "charge" : "task", pair.site},
          {"uav", pair.uav.value},
          {pair.charging ? "vehicle" : "worker", pair.partner},
          {"uav_free_s", pair.uav_free_us ? Seconds(*pair.uav_free_us) : Json()},
          {pair.charging ? "vehicle_free_s" : "worker_free_s",
           pair.partner_free_us ? Seconds(*pair.partner_free_us) : Json()},
          {"worth", pair.worth},
          {"end_s", Seconds(pair.end_us)},
          {"matching", pair.second ? 2 : 1}};
}

Json PlansJson(const std::vector<PairPlan>& pairs) {
  Json list = Json::array();
  for (const PairPlan& pair : pairs) list.push_back(PlanJson(pair));
  return list;
}

Json DoneJson(const std::optional<std::size_t>& done) { return done ? Json(*done) : Json(); }

Json ForcingJson(const std::optional<HorizonForcing>& forcing) {
  if (!forcing) return {};
  Json displaced = Json::array();
  for (const TaskId task : forcing->displaced) displaced.push_back(task.value);
  return {{"cost", forcing->cost},
          {"exact", forcing->exact},
          {"cost_between", {forcing->cost_low, forcing->cost_high}},
          {"pair", PlanJson(forcing->pair)},
          {"tasks_displaced", std::move(displaced)},
          {"forecast_done", DoneJson(forcing->forecast_done)}};
}

Json OptionJson(const HorizonOption& option) {
  return {{option.charging ? "charge" : "task", option.site},
          {"pair", FactJson(option.pair, option.charging)},
          {"outbid_by", PlansJson(option.rivals)}};
}

Json FateJson(const PairPlan& pair, const Fate& fate) {
  Json json = {{"plan", PlanJson(pair)}, {"outcome", ToString(fate.kind)}};
  json["decision"] = fate.decision < 0 ? Json() : Json(fate.decision);
  json["still_planned_in"] = fate.kept;
  if (fate.member_kind) json["member"] = AgentName(*fate.member_kind, fate.member);
  if (fate.taken_by) json["taken_by"] = ActionJson(ToWire(*fate.taken_by));
  if (!fate.rivals.empty()) json["outbid_by"] = PlansJson(fate.rivals);
  if (fate.look) json["pairs"] = FactJson(*fate.look);
  return json;
}

template <class Answer>
void AddHow(const HorizonChapter<Answer>& chapter, Json* json) {
  (*json)["made_again"] = chapter.again;
  (*json)["settings"] = chapter.settings;
  if (chapter.forecast) {
    (*json)["variant"] = chapter.variant + 1;
    (*json)["variants"] = chapter.variants;
    (*json)["draws"] = chapter.draws;
  }
  Json fates = Json::array();
  for (const auto& [pair, fate] : chapter.fates) fates.push_back(FateJson(pair, fate));
  (*json)["planned"] = std::move(fates);
}

void AddQuality(const HorizonQuality& quality, Json* json) {
  (*json)["worth"] = quality.worth;
  (*json)["bound"] = quality.bound;
  (*json)["forecast_done"] = DoneJson(quality.forecast_done);
}

}  // namespace

void AddHorizon(const HorizonChapter<scheduler::TaskAnswer>& chapter, Json* json) {
  const auto& answer = chapter.answer;
  (*json)["verdict"] = ToString(answer.verdict);
  if (answer.verdict == HorizonVerdict::kDone || answer.verdict == HorizonVerdict::kUnreported ||
      answer.verdict == HorizonVerdict::kExpired) {
    return;
  }
  if (answer.verdict == HorizonVerdict::kUnderWay) {
    if (answer.activity) (*json)["pair"] = FactJson(*answer.activity);
    return;
  }
  AddHow(chapter, json);
  (*json)["commanded"] = ActionsJson(answer.commanded);
  (*json)["pairs"] = FactJson(answer.look);
  if (answer.options.empty()) return;
  Json options = Json::array();
  for (const HorizonOption& option : answer.options) options.push_back(OptionJson(option));
  (*json)["options"] = std::move(options);
  (*json)["forcing"] = ForcingJson(answer.forcing);
  AddQuality(answer.quality, json);
}

void AddHorizon(const HorizonChapter<scheduler::AgentAnswer>& chapter, Json* json) {
  const auto& answer = chapter.answer;
  (*json)["condition"] = ToString(answer.condition);
  if (answer.condition == AgentCondition::kBusy && answer.state) {
    (*json)["under_way"] = FactJson(*answer.state);
    (*json)["free_s"] = answer.free_us ? Seconds(*answer.free_us) : Json();
  }
  const bool takes_part = answer.condition == AgentCondition::kIdle || answer.free_us;
  if (!takes_part) return;
  AddHow(chapter, json);
  if (answer.did) (*json)["did"] = ActionJson(ToWire(*answer.did));
  (*json)["matched"] = PlansJson(answer.plans);
  (*json)["places_feasible"] = answer.places_feasible;
  Json options = Json::array();
  for (std::size_t i = 0; i < answer.options.size(); ++i) {
    Json option = OptionJson(answer.options[i]);
    option["forcing"] = ForcingJson(answer.forcings[i]);
    options.push_back(std::move(option));
  }
  (*json)["options"] = std::move(options);
  (*json)["blocked"] = FactJson(answer.blocked);
  if (!answer.options.empty()) AddQuality(answer.quality, json);
}

}  // namespace muster::tools
