#include "scheduler/policies/learned/features.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/index.h"
#include "model/feasibility.h"
#include "scheduler/policy.h"
#include "scheduler/weights.h"

namespace muster::scheduler::learned {
namespace {

/// Half the side of the box in which other open tasks are counted.
constexpr double kBoxM = 3500;
constexpr float kMostIntervals = 4;

struct Near {
  double way_m;
  PlaceOption option;
};

class Observer {
 public:
  Observer(const Situation& situation, const Shape& shape)
      : s_(situation), site_(*situation.site), shape_(shape) {
    for (std::size_t x = 0; x < site_.tasks.size(); ++x) {
      if (s_.task_status[x] == TaskStatus::kOpen) open_.push_back(static_cast<std::int32_t>(x));
    }
    for (std::size_t y = 0; y < site_.charging_points.size(); ++y) {
      if (s_.free_places(ChargeId(y)) > 0) free_.push_back(static_cast<std::int32_t>(y));
    }
    task_box_.assign(site_.tasks.size(), -1);
    point_box_.assign(site_.charging_points.size(), -1);
  }

  Observation Observe() {
    Observation observation;
    for (const AgentKind kind : kAgentKinds) {
      const auto& agents = s_.agents(kind);
      for (std::size_t i = 0; i < agents.size(); ++i) {
        if (!agents[i].idle(s_.now_us) || agents[i].id >= shape_.agents[kind]) continue;
        observation.agents[kind].push_back(View(agents[i], static_cast<std::int32_t>(i)));
      }
    }
    for (const AgentKind kind : kAgentKinds) {
      for (AgentView& view : observation.agents[kind]) Describe(kind, &view, observation);
    }
    Map(observation, &observation.maps);
    return observation;
  }

 private:
  double LimitUs() const { return static_cast<double>(site_.rules.limit_us); }

  AgentView View(const AgentState& agent, std::int32_t position) {
    AgentView view;
    view.id = agent.id;
    view.position = position;
    view.at = agent.to;
    view.reach_m = agent.speed_m_s * ToSeconds(site_.rules.interval_us);
    const double range = s_.range_m(agent);
    const bool is_uav = agent.kind == AgentKind::kUav;
    double charge = std::numeric_limits<double>::infinity();
    for (const ChargingPoint& point : site_.charging_points) {
      charge = std::min(charge, agent.WayM(agent.to, point.at));
    }
    const TimeUs until = std::min(agent.online_until_us, site_.rules.limit_us);
    view.own = {static_cast<float>(agent.to.x_m / site_.width_m),
                static_cast<float>(agent.to.y_m / site_.height_m),
                is_uav ? static_cast<float>(Urgency(agent, range)) : 0.0F,
                static_cast<float>(static_cast<double>(s_.now_us) / LimitUs()),
                static_cast<float>(static_cast<double>(until - s_.now_us) / LimitUs()),
                is_uav ? static_cast<float>(range / agent.range_full_m) : 0.0F,
                std::min(kMostIntervals, static_cast<float>(charge / view.reach_m))};
    view.options[0] = {PlaceOption::Kind::kStay, -1};
    Fill(agent, range, &view);
    return view;
  }

  /// The nearest places that it may go to.
  void Fill(const AgentState& agent, double range, AgentView* view) {
    const TimeUs latest = LatestEnd(agent, site_.rules);
    const auto arrives = [&](double way, double then_m) {
      const TimeUs travel = TravelUs(way + then_m, agent.speed_m_s);
      return travel != kNever && (latest == kNever || travel <= latest - s_.now_us);
    };
    std::vector<Near> tasks, points;
    if (agent.kind != AgentKind::kVehicle) {
      for (const std::int32_t x : open_) {
        const Task& task = site_.tasks[At(x)];
        const double way = agent.WayM(agent.to, task.at);
        const bool is_uav = agent.kind == AgentKind::kUav;
        if (site_.Forbids(agent, x)) continue;
        if (is_uav && !CanSense(range, way, task.cost_m, site_.task_to_charge_m[At(x)])) continue;
        if (!arrives(way, is_uav ? task.cost_m : 0)) continue;
        if (!CanBegin(task, s_.now_us, TravelUs(way, agent.speed_m_s))) continue;
        tasks.push_back({way, {PlaceOption::Kind::kTask, x}});
      }
    }
    if (agent.kind != AgentKind::kWorker) {
      for (const std::int32_t y : free_) {
        const double way = agent.WayM(agent.to, site_.charging_points[At(y)].at);
        if (agent.kind == AgentKind::kUav && !CanReachCharge(range, way)) continue;
        if (arrives(way, 0)) points.push_back({way, {PlaceOption::Kind::kCharge, y}});
      }
    }
    int next = 1;
    const auto take = [&](std::vector<Near>* near, int most) {
      const auto n = std::min(near->size(), At(most));
      std::partial_sort(near->begin(), near->begin() + static_cast<std::ptrdiff_t>(n), near->end(),
                        [](const Near& a, const Near& b) {
                          return a.way_m != b.way_m ? a.way_m < b.way_m
                                                    : a.option.site < b.option.site;
                        });
      for (std::size_t i = 0; i < n; ++i) view->options[At(next++)] = (*near)[i].option;
    };
    take(&tasks, agent.kind == AgentKind::kUav ? kTaskOptions : kOptions - 1);
    take(&points, kOptions - next);
  }

  Point PlaceOf(const AgentView& view, const PlaceOption& option) const {
    if (option.kind == PlaceOption::Kind::kTask) return site_.tasks[At(option.site)].at;
    if (option.kind == PlaceOption::Kind::kCharge) return site_.charging_points[At(option.site)].at;
    return view.at;
  }

  float TasksAround(Point at) const {
    int n = 0;
    for (const std::int32_t x : open_) {
      const Point task = site_.tasks[At(x)].at;
      n += std::abs(task.x_m - at.x_m) <= kBoxM && std::abs(task.y_m - at.y_m) <= kBoxM;
    }
    return static_cast<float>(n) / 8;
  }

  float TasksAround(const AgentView& view, const PlaceOption& option) {
    if (option.kind == PlaceOption::Kind::kStay) return TasksAround(view.at);
    auto& box = option.kind == PlaceOption::Kind::kTask ? task_box_ : point_box_;
    float& known = box[At(option.site)];
    if (known < 0) known = TasksAround(PlaceOf(view, option));
    return known;
  }

  void Describe(AgentKind kind, AgentView* view, const Observation& all) {
    for (std::size_t k = 0; k < kOptions; ++k) {
      const PlaceOption& option = view->options[k];
      if (option.kind == PlaceOption::Kind::kNone) continue;
      const Point place = PlaceOf(*view, option);
      const double way = site_.ways->Length(kind, view->at, place);
      const auto intervals = static_cast<float>(way / view->reach_m);
      PerKind<int> reaching;
      int nearer = 0;
      const AgentKind partner_kind = kind != AgentKind::kUav ? AgentKind::kUav
                                     : option.kind == PlaceOption::Kind::kCharge
                                         ? AgentKind::kVehicle
                                         : AgentKind::kWorker;
      float partner_intervals = kMostIntervals;
      const AgentView* partner = nullptr;
      for (const AgentKind other_kind : kAgentKinds) {
        for (const AgentView& other : all.agents[other_kind]) {
          const double distance = site_.ways->Length(other_kind, other.at, place);
          reaching[other_kind] += distance <= other.reach_m;
          if (other_kind == kind) {
            nearer += distance < way || (distance == way && other.id < view->id);
          } else if (other_kind == partner_kind) {
            const auto its = static_cast<float>(distance / other.reach_m);
            if (its < partner_intervals) partner_intervals = its, partner = &other;
          }
        }
      }
      auto& f = view->features[k];
      f = {static_cast<float>((place.x_m - view->at.x_m) / view->reach_m),
           static_cast<float>((place.y_m - view->at.y_m) / view->reach_m),
           intervals,
           way <= view->reach_m ? 1.0F : 0.0F,
           option.kind == PlaceOption::Kind::kTask ? 1.0F : 0.0F,
           option.kind == PlaceOption::Kind::kCharge ? 1.0F : 0.0F,
           static_cast<float>(reaching.uavs) / 4,
           static_cast<float>(reaching.workers) / 4,
           static_cast<float>(reaching.vehicles) / 4,
           TasksAround(*view, option)};
      if (option.kind == PlaceOption::Kind::kStay) continue;
      f[10] = std::min(4.0F, static_cast<float>(nearer) / 4);
      f[11] = partner_intervals;
      f[12] = std::max(intervals, partner_intervals);
      f[13] = partner == nullptr ? kMostIntervals : RankOf(*partner, option);
    }
    for (std::size_t k = 0; k < kOptions; ++k) {
      for (float& value : view->features[k]) value = std::clamp(value, -4.0F, 4.0F);
    }
  }

  /// How many options of the same sort that agent has before this one, in fours.
  static float RankOf(const AgentView& agent, const PlaceOption& option) {
    int rank = 0;
    for (const PlaceOption& its : agent.options) {
      if (its.kind != option.kind) continue;
      if (its.site == option.site) break;
      ++rank;
    }
    return static_cast<float>(rank) / 4;
  }

  void Map(const Observation& observation, std::vector<std::uint8_t>* maps) const {
    const std::size_t cells = At(shape_.rows * shape_.columns);
    std::vector<float> sums(At(kMaps) * cells, 0.0F);
    const auto add = [&](std::size_t map, Point at, float value) {
      const auto cell = [](double metres, int n) {
        return std::clamp(static_cast<int>(metres / 1000), 0, n - 1);
      };
      sums[map * cells +
           At(cell(at.y_m, shape_.rows) * shape_.columns + cell(at.x_m, shape_.columns))] += value;
    };
    std::size_t map = 0;
    for (const AgentKind kind : kAgentKinds) {
      for (const AgentView& view : observation.agents[kind]) add(map, view.at, 1);
      ++map;
    }
    for (const AgentView& view : observation.agents.uavs) add(3, view.at, 32 * view.own[2]);
    for (const std::int32_t x : open_) add(4, site_.tasks[At(x)].at, 1);
    for (const std::int32_t y : free_) add(5, site_.charging_points[At(y)].at, 1);
    maps->resize(sums.size());
    std::transform(sums.begin(), sums.end(), maps->begin(), [](float sum) {
      return static_cast<std::uint8_t>(std::lround(std::min(sum, 255.0F)));
    });
  }

  const Situation& s_;
  const Site& site_;
  const Shape& shape_;
  std::vector<std::int32_t> open_, free_;
  std::vector<float> task_box_, point_box_;  ///< TasksAround, -1: not known yet
};

/// Turns choices into actions.
class Resolver {
 public:
  Resolver(const Situation& situation, const Observation& observation, const Choices& choices)
      : s_(situation), rules_(situation.site->rules), seen_(observation), choices_(choices) {
    for (const AgentKind kind : kAgentKinds) paired_[kind].assign(choices[kind].size(), 0);
    for (std::size_t y = 0; y < s_.site->charging_points.size(); ++y) {
      free_.push_back(s_.free_places(ChargeId(y)));
    }
    taken_.assign(s_.site->tasks.size(), 0);
  }

  std::vector<Action> Actions() {
    for (std::size_t u = 0; u < seen_.agents.uavs.size(); ++u) {
      const PlaceOption& option = Chosen(AgentKind::kUav, u);
      if (option.kind == PlaceOption::Kind::kTask) Pair(u, option, AgentKind::kWorker);
      if (option.kind == PlaceOption::Kind::kCharge) Pair(u, option, AgentKind::kVehicle);
    }
    for (const AgentKind kind : kAgentKinds) {
      for (std::size_t i = 0; i < seen_.agents[kind].size(); ++i) {
        if (!paired_[kind][i]) Go(kind, i);
      }
    }
    return std::move(actions_);
  }

 private:
  const PlaceOption& Chosen(AgentKind kind, std::size_t i) const {
    return seen_.agents[kind][i].options[At(choices_[kind][i])];
  }
  const AgentState& StateOf(AgentKind kind, std::size_t i) const {
    return s_.agents(kind)[At(seen_.agents[kind][i].position)];
  }
  Point PlaceOf(const PlaceOption& option) const {
    return option.kind == PlaceOption::Kind::kTask ? s_.site->tasks[At(option.site)].at
                                                   : s_.site->charging_points[At(option.site)].at;
  }
  void Pair(std::size_t u, const PlaceOption& option, AgentKind partner_kind) {
    const bool senses = option.kind == PlaceOption::Kind::kTask;
    if (senses ? taken_[At(option.site)] != 0 : free_[At(option.site)] <= 0) return;
    for (std::size_t p = 0; p < seen_.agents[partner_kind].size(); ++p) {
      const PlaceOption& its = Chosen(partner_kind, p);
      if (paired_[partner_kind][p] || its.kind != option.kind || its.site != option.site) continue;
      const AgentState &uav = StateOf(AgentKind::kUav, u), &partner = StateOf(partner_kind, p);
      const Action action =
          MakeAction(*s_.site, &uav, &partner, senses ? TaskId(option.site) : TaskId(),
                     senses ? ChargeId() : ChargeId(option.site));
      if (!MayPair(uav, partner, action)) continue;
      actions_.push_back(action);
      paired_.uavs[u] = paired_[partner_kind][p] = 1;
      senses ? void(taken_[At(option.site)] = 1) : void(--free_[At(option.site)]);
      return;
    }
  }

  /// Whether they meet before the next decision and end in time.
  bool MayPair(AgentState uav, AgentState partner, const Action& action) const {
    for (AgentState* agent : {&uav, &partner}) {
      Begin(agent, action, s_.decision, s_.now_us, Disturbances(), s_.site->seed);
    }
    const Activity activity = PlanActivity(uav, partner, s_.site->tasks);
    const TimeUs latest = std::min(LatestEnd(uav, rules_), LatestEnd(partner, rules_));
    return activity.end_us != kNever && activity.end_us <= latest &&
           activity.start_us <= s_.now_us + rules_.interval_us;
  }

  void Go(AgentKind kind, std::size_t i) {
    const PlaceOption& option = Chosen(kind, i);
    const AgentState& agent = StateOf(kind, i);
    Action action = MakeStay(*s_.site, agent);
    const TimeUs longest = std::min(rules_.interval_us, Left(agent));
    if (option.kind != PlaceOption::Kind::kStay && longest > 1) {
      const Point place = PlaceOf(option);
      const TimeUs travel = TravelUs(agent.WayM(agent.to, place), agent.speed_m_s);
      // A little less than the time allows, so that rounding does not make it longer.
      action.to = travel <= longest ? place
                                    : agent.ways->PlaceAfter(kind, agent.to, place,
                                                             static_cast<double>(longest - 1) /
                                                                 static_cast<double>(travel));
      if (!(action.to == agent.to)) action.kind = ActionKind::kGoTo;
    }
    actions_.push_back(action);
  }

  TimeUs Left(const AgentState& agent) const {
    const TimeUs latest = LatestEnd(agent, rules_);
    return latest == kNever ? kNever : latest - s_.now_us;
  }

  const Situation& s_;
  const Rules& rules_;
  const Observation& seen_;
  const Choices& choices_;
  PerKind<std::vector<char>> paired_;
  std::vector<std::int32_t> free_;
  std::vector<char> taken_;
  std::vector<Action> actions_;
};

}  // namespace

double Urgency(const AgentState& uav, double range_m) {
  return 1 - TaskLikelihood(range_m / uav.range_full_m);
}

Observation Observe(const Situation& situation, const Shape& shape) {
  return Observer(situation, shape).Observe();
}

std::vector<Action> ActionsOf(const Situation& situation, const Observation& observation,
                              const Choices& choices) {
  return Resolver(situation, observation, choices).Actions();
}

}  // namespace muster::scheduler::learned
