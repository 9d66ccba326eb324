#include "scheduler/policies/horizon/horizon.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "base/index.h"
#include "model/feasibility.h"
#include "scheduler/policies/horizon/matching.h"
#include "scheduler/separation/keep_apart.h"

namespace muster::scheduler {
namespace {

class Planner {
 public:
  Planner(const Situation& situation, const HorizonSettings& settings, int threads)
      : situation_(situation),
        settings_(settings),
        threads_(threads),
        participants_(ParticipantsOf(situation, settings)),
        open_(OpenSitesOf(situation)) {
    for (const AgentKind kind : kAgentKinds) used_[kind].assign(participants_[kind].size(), 0);
  }

  /// candidates, when given, takes the number of pairs to choose from.
  std::vector<Action> Decide(std::int64_t* candidates) {
    return Decide(HeaviestPairs(situation_, participants_, open_, settings_, threads_, candidates));
  }

  /// The rest of a decision with that first matching. `plan`, when given, takes what it rests on.
  std::vector<Action> Decide(const std::vector<Match>& first, HorizonPlan* plan = nullptr) {
    if (plan != nullptr) plan->now = participants_;
    for (const Match& match : first) Command(match);
    std::vector<Match> second;
    if (settings_.send_ahead) {
      for (const Match& match : first) Advance(match);
      HorizonSettings settings = settings_;
      if (settings.radio) settings.radio->exchange = 1;
      second = HeaviestPairs(situation_, participants_, open_, settings, threads_);
      for (const Match& match : second) {
        const bool uav = Free(match, AgentKind::kUav);
        const bool partner = Free(match, PartnerKindOf(match));
        if (uav && partner) {
          Pair(match);
        } else if (uav || partner) {
          Go(match, uav ? AgentKind::kUav : PartnerKindOf(match));
        }
      }
    }
    if (plan != nullptr) {
      plan->first = first;
      plan->then = std::move(participants_);
      plan->second = std::move(second);
    }
    return std::move(actions_);
  }

  HorizonPlan Plan(const std::vector<Match>* first) {
    HorizonPlan plan;
    std::int64_t candidates = 0;
    std::vector<Action> actions = Decide(
        first != nullptr
            ? *first
            : HeaviestPairs(situation_, participants_, open_, settings_, threads_, &candidates),
        &plan);
    plan.decision = MakeDecision(std::move(actions), candidates);
    return plan;
  }

 private:
  Participant& Member(const Match& match, AgentKind kind) {
    return participants_[kind][At(kind == AgentKind::kUav ? match.uav : match.partner)];
  }
  char& Used(const Match& match, AgentKind kind) {
    return used_[kind][At(kind == AgentKind::kUav ? match.uav : match.partner)];
  }
  Action Base(const Match& match) const {
    Action action;
    if (match.charging) {
      action.charge = ChargeId(match.site);
    } else {
      action.task = TaskId(match.site);
    }
    action.to = PlaceOf(*situation_.site, match);
    action.weight = match.weight;
    return action;
  }

  /// A pair of idle agents is commanded; of another one the idle member may go ahead.
  void Command(const Match& match) {
    const Participant& uav = Member(match, AgentKind::kUav);
    const Participant& partner = Member(match, PartnerKindOf(match));
    if (uav.idle && partner.idle) {
      if (settings_.steps && !MeetsBeforeNextDecision(match)) {
        Go(match, AgentKind::kUav);
        Go(match, PartnerKindOf(match));
      } else {
        Pair(match);
      }
    } else if (settings_.meet_ahead && (uav.idle || partner.idle)) {
      const AgentKind kind = uav.idle ? AgentKind::kUav : PartnerKindOf(match);
      if (GoingAheadHelps(match, kind)) Go(match, kind);
    }
    Used(match, AgentKind::kUav) = 1;
    Used(match, PartnerKindOf(match)) = 1;
  }

  void Pair(const Match& match) {
    Action action = Base(match);
    action.kind = match.charging ? ActionKind::kCharge : ActionKind::kSense;
    action.uav = UavId(Member(match, AgentKind::kUav).agent->id);
    (match.charging ? action.vehicle.value : action.worker.value) =
        Member(match, PartnerKindOf(match)).agent->id;
    actions_.push_back(action);
  }

  TimeUs Travel(const Participant& member, Point to) const {
    return TravelUs(member.agent->WayM(member.at, to), member.agent->speed_m_s);
  }

  /// Whether the pair meets no later when the idle member leaves now and the pair is made once both
  /// are free, than when both leave as a pair once the other is free.
  bool GoingAheadHelps(const Match& match, AgentKind idle_kind) {
    const Participant& idle = Member(match, idle_kind);
    const Participant& other =
        Member(match, idle_kind == AgentKind::kUav ? PartnerKindOf(match) : AgentKind::kUav);
    const TimeUs interval = situation_.site->rules.interval_us;
    const TimeUs way = Travel(idle, PlaceOf(*situation_.site, match)),
                 other_way = Travel(other, PlaceOf(*situation_.site, match));
    const TimeUs ahead =
        std::max(other.ready_us, DecisionAfter(situation_.now_us + way, interval)) + other_way;
    return ahead <= other.ready_us + std::max(way, other_way);
  }

  TimeUs NextDecision() const { return situation_.site->rules.NextDecisionUs(situation_.now_us); }

  bool MeetsBeforeNextDecision(const Match& match) {
    const Participant& uav = Member(match, AgentKind::kUav);
    const Participant& partner = Member(match, PartnerKindOf(match));
    return situation_.now_us + std::max(Travel(uav, PlaceOf(*situation_.site, match)),
                                        Travel(partner, PlaceOf(*situation_.site, match))) <
           NextDecision();
  }

  /// An idle member goes to the place of its match, or with `steps` as far as it gets before the
  /// next decision.
  void Go(const Match& match, AgentKind kind) {
    const Participant& member = Member(match, kind);
    const TimeUs travel = Travel(member, PlaceOf(*situation_.site, match));
    if (member.at == PlaceOf(*situation_.site, match)) return;
    Action action = Base(match);
    action.weight = 0;
    TimeUs arrive = situation_.now_us + travel;
    if (settings_.steps) {
      action.task = {};
      action.charge = {};
      action.kind = ActionKind::kGoTo;
      if (arrive > NextDecision()) {
        // A little less than the interval allows, so that rounding does not make it longer.
        const double share = static_cast<double>(NextDecision() - situation_.now_us - 1) /
                             static_cast<double>(travel);
        action.to = situation_.site->ways->StopBefore(kind, member.at, action.to, share);
        if (action.to == member.at) return;
        arrive = NextDecision();
      }
    }
    if (arrive > member.latest_us) return;
    switch (kind) {
      case AgentKind::kUav:
        action.uav = UavId(member.agent->id);
        if (!settings_.steps) {
          action.kind = match.charging ? ActionKind::kUavToCharge : ActionKind::kUavToTask;
        }
        break;
      case AgentKind::kWorker:
        action.worker = WorkerId(member.agent->id);
        if (!settings_.steps) action.kind = ActionKind::kWorkerToTask;
        break;
      case AgentKind::kVehicle:
        action.vehicle = VehicleId(member.agent->id);
        if (!settings_.steps) action.kind = ActionKind::kVehicleToCharge;
        break;
    }
    actions_.push_back(action);
  }

  /// Members and site as they will be after the pair.
  void Advance(const Match& match) {
    Participant& uav = Member(match, AgentKind::kUav);
    Participant& partner = Member(match, PartnerKindOf(match));
    const double way = uav.agent->WayM(uav.at, PlaceOf(*situation_.site, match));
    if (match.charging) {
      uav.range_m = uav.agent->range_full_m;
      --open_.place[At(match.site)];
    } else {
      uav.range_m -= way + situation_.site->tasks[At(match.site)].cost_m;
      open_.task[At(match.site)] = 0;
    }
    for (Participant* member : {&uav, &partner}) {
      member->at = PlaceOf(*situation_.site, match);
      member->ready_us = DecisionAfter(match.end_us, situation_.site->rules.interval_us);
    }
  }

  /// Idle and not used by the first matching.
  bool Free(const Match& match, AgentKind kind) {
    return !Used(match, kind) && Member(match, kind).idle;
  }

  const Situation& situation_;
  const HorizonSettings& settings_;
  int threads_;
  Participants participants_;
  OpenSites open_;
  PerKind<std::vector<char>> used_;  ///< by the first matching
  std::vector<Action> actions_;
};

}  // namespace

Decision HorizonPolicy::Decide(const Situation& situation) {
  std::int64_t candidates = 0;
  std::vector<Action> actions = Planner(situation, settings_, threads_).Decide(&candidates);
  return MakeDecision(std::move(actions), candidates);
}

Deciding HorizonPolicy::Explain(const Situation& situation,
                                const std::vector<Action>& commanded) const {
  Deciding deciding;
  deciding.how.settings = settings_;
  deciding.plan = PlanHorizon(situation, settings_);
  // Of what was decided, UAVs that are kept apart do only what an altitude is free for.
  deciding.how.again = KeepApart(situation, deciding.plan.decision).actions == commanded;
  return deciding;
}

bool HorizonPolicy::Set(std::string_view key, double value) {
  if (!settings_.radio) return false;
  if (key == "reach") settings_.radio->reach_m = value * 1e3;
  if (key == "loss") settings_.radio->loss = value;
  return key == "reach" || key == "loss";
}

std::vector<Action> HorizonPolicy::ActionsOf(const Situation& situation) const {
  return Planner(situation, settings_, threads_).Decide(nullptr);
}

HorizonPlan PlanHorizon(const Situation& situation, const HorizonSettings& settings,
                        const std::vector<Match>* first) {
  return Planner(situation, settings, 1).Plan(first);
}

}  // namespace muster::scheduler
