#include "scheduler/policies/rollout/rollout.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "base/check.h"
#include "scheduler/policies/rollout/expected_tasks.h"
#include "scheduler/solver/parallel.h"

namespace muster::scheduler {

std::vector<HorizonSettings> RolloutSettings::DefaultVariants() {
  const HorizonSettings base;
  std::vector<HorizonSettings> variants = {base};
  const auto add = [&](auto change) {
    HorizonSettings variant = base;
    change(&variant);
    variants.push_back(variant);
  };
  add([](HorizonSettings* s) { s->patience = 0.6; });
  add([](HorizonSettings* s) { s->patience = 1.6; });
  add([](HorizonSettings* s) { s->uav_way = 0.15; });
  add([](HorizonSettings* s) { s->uav_way = 0.7; });
  add([](HorizonSettings* s) { s->finish_weight = 0.4; });
  add([](HorizonSettings* s) { s->charge_worth = 0.4; });
  add([](HorizonSettings* s) { s->charge_worth = 1.2; });
  add([](HorizonSettings* s) { s->tentative = 0.8; });
  add([](HorizonSettings* s) { s->soon_idle = false; });
  add([](HorizonSettings* s) { s->partner_way = 0.04; });
  add([](HorizonSettings* s) { s->soon_decisions = 4; });
  add([](HorizonSettings* s) { s->chains = false; });
  return variants;
}

namespace {

/// When so many tasks get done, nothing better is looked for: all that there are. Where some matter
/// more, or when they begin matters, or in several futures, there is no such number.
std::size_t AllThatCanBeDone(const std::vector<Future>& futures) {
  if (futures.size() > 1) return SIZE_MAX;
  const Situation& situation = futures.front().situation;
  std::size_t left = 0;
  for (std::size_t x = 0; x < situation.task_status.size(); ++x) {
    if (!futures.front().MayBeDone(x)) continue;
    const Task& task = situation.site->tasks[x];
    if (task.due_us != kNever || task.priority != Priority::kNormal) return SIZE_MAX;
    ++left;
  }
  return left;
}

}  // namespace

RolloutPolicy::RolloutPolicy(RolloutSettings settings) : settings_(std::move(settings)) {
  MUSTER_CHECK(!settings_.variants.empty() && settings_.work > 0 && settings_.rounds > 0 &&
                   settings_.futures > 0,
               "work={} rounds={} futures={}", settings_.work, settings_.rounds, settings_.futures);
}

bool RolloutPolicy::Set(std::string_view key, double value) {
  if (key == "expect") settings_.expect_per_hour = value;
  if (key == "shifts") settings_.shifts = value != 0;
  if (key == "effort") settings_.effort = static_cast<std::int64_t>(value);
  return key == "expect" || key == "shifts" || key == "effort";
}

std::vector<Future> RolloutPolicy::FuturesOf(const Situation& situation) const {
  std::vector<Future> futures;
  const int n = settings_.expect_per_hour > 0 ? settings_.futures : 1;
  for (int i = 0; i < n; ++i) {
    futures.push_back(
        ExpectTasks(situation, settings_.expect_per_hour, static_cast<std::uint32_t>(i)));
  }
  if (settings_.shifts) {
    const auto coming = ComingAgents(situation);
    for (Future& future : futures) future.coming = coming;
  }
  return futures;
}

void RolloutPolicy::Follow(const Situation& situation, const std::vector<Future>& futures,
                           Clock::time_point start, std::int64_t work, const RolloutPlan* known,
                           std::vector<RolloutPlan>* plans) const {
  const std::size_t n = plans->size();
  /// Calls body(plan) for every plan, by two threads at once.
  const auto for_each = [&](auto body) {
    std::atomic<std::size_t> next{0};
    const auto run = [&] {
      for (std::size_t i = next++; i < n; i = next++) body(&(*plans)[i]);
    };
    if (settings_.threads < 2) return run();
    AtOnce(run, run);
  };
  // Without time for anything, the first variant's decision stands.
  const auto late = [&](const RolloutPlan* plan) {
    return settings_.deadline && (known != nullptr || plan != plans->data()) &&
           Clock::now() - start >= *settings_.deadline;
  };
  for_each([&](RolloutPlan* plan) {
    if (plan->decided || late(plan)) return;
    plan->decision = HorizonPolicy(plan->settings).Decide(situation);
    plan->decided = true;
  });

  const auto same = [](const RolloutPlan& a, const RolloutPlan& b) {
    const auto &x = a.decision.actions, &y = b.decision.actions;
    return std::equal(x.begin(), x.end(), y.begin(), y.end(), [](Action p, Action q) {
      p.weight = q.weight = 0;
      return p == q;
    });
  };
  std::vector<char> skip(n, 0);
  std::size_t different = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const RolloutPlan& plan = (*plans)[i];
    skip[i] = !plan.decided || (known != nullptr && same(plan, *known));
    for (std::size_t j = 0; j < i && !skip[i]; ++j) {
      skip[i] = (*plans)[j].decided && same(plan, (*plans)[j]);
    }
    if (!skip[i]) ++different;
  }
  if (different == 0) return;
  const std::int64_t depth = std::max<std::int64_t>(1, work / static_cast<std::int64_t>(different));
  for_each([&](RolloutPlan* plan) {
    if (skip[static_cast<std::size_t>(plan - plans->data())] || late(plan)) return;
    plan->followed = true;
    plan->forecast =
        ForecastOf(futures, plan->decision.actions, plan->follow, depth, settings_.early);
  });
}

void RolloutPolicy::AddDraw(std::uint32_t draw, HorizonSettings* settings) const {
  auto& [around_variant, around_draw] = settings->jitters;
  if (around_variant.most == 0) {
    around_variant = {settings_.jitter, draw};
  } else {
    around_draw = {settings_.later_jitter, draw};
  }
}

RolloutPlan RolloutPolicy::Search(const Situation& situation, const std::vector<Future>& futures,
                                  Clock::time_point start, std::int64_t work,
                                  RolloutPlan found) const {
  const Rules& rules = situation.site->rules;
  const std::int64_t to_go = Intervals(rules.limit_us - situation.now_us, rules.interval_us);
  SearchLimits limits;
  limits.forecasts = work / to_go;
  limits.threads = settings_.threads;
  limits.early = settings_.early;
  if (settings_.deadline) {
    limits.until = start + *settings_.deadline;
    if (*limits.until <= Clock::now()) return found;
  }
  SearchedPlan searched = SearchPlans(situation, futures, found.follow, limits);
  if (searched.forecast.worth <= found.forecast.worth + 1e-9) return found;
  found.decision = HorizonPolicy(searched.settings, settings_.threads).Decide(situation);
  found.settings = found.follow = std::move(searched.settings);
  found.forecast = searched.forecast;
  return found;
}

Decision RolloutPolicy::Decide(const Situation& situation) {
  return Plan(situation, FuturesOf(situation)).decision;
}

RolloutPlan RolloutPolicy::Plan(const Situation& situation,
                                const std::vector<Future>& futures) const {
  const auto start = Clock::now();
  const auto best_of = [](const std::vector<RolloutPlan>& plans, const RolloutPlan* best) {
    for (const RolloutPlan& plan : plans) {
      if (plan.followed && (best == nullptr || plan.forecast.worth > best->forecast.worth + 1e-9)) {
        best = &plan;
      }
    }
    return best;
  };
  RolloutPlan first;
  first.settings = first.follow = settings_.variants[0];
  first.decision = HorizonPolicy(first.settings, settings_.threads).Decide(situation);
  first.decided = true;
  const std::int64_t pairs = std::max<std::int64_t>(1, first.decision.candidates);
  const std::int64_t wanted = pairs > settings_.many_pairs ? settings_.work / 2 : settings_.work;
  const std::int64_t allowed = settings_.pairs / pairs / static_cast<std::int64_t>(futures.size());
  const std::int64_t work = std::min(wanted, allowed * settings_.effort);
  /// How many plans are followed, so that they can go to the end where work is short.
  const auto at_most = [&](std::size_t n) {
    if (work == settings_.work) return n;
    const Rules& rules = situation.site->rules;
    const std::int64_t to_go = Intervals(rules.limit_us - situation.now_us, rules.interval_us);
    return std::min(n, static_cast<std::size_t>(work / to_go));
  };
  std::vector<RolloutPlan> variants(at_most(settings_.variants.size()));
  if (variants.size() < std::min<std::size_t>(2, settings_.variants.size())) return first;
  for (std::size_t i = 0; i < variants.size(); ++i) {
    variants[i].settings = variants[i].follow = settings_.variants[i];
    variants[i].variant = static_cast<std::int32_t>(i);
  }
  variants[0] = first;
  Follow(situation, futures, start, work, nullptr, &variants);
  const RolloutPlan* best = best_of(variants, nullptr);

  const std::size_t left = AllThatCanBeDone(futures);
  if (best->forecast.done >= left || best->decision.actions.empty()) return *best;
  const auto rounds = static_cast<std::size_t>(settings_.rounds);
  const auto all = static_cast<std::size_t>(settings_.draws);
  RolloutPlan found = *best;
  for (std::size_t round = 0; round < rounds && found.forecast.done < left; ++round) {
    std::vector<RolloutPlan> near(at_most(all) / rounds);
    for (std::size_t i = 0; i < near.size(); ++i) {
      near[i].settings = found.settings;
      near[i].follow = found.follow;
      near[i].variant = found.variant;
      AddDraw(static_cast<std::uint32_t>(round * (all / rounds) + i), &near[i].settings);
    }
    Follow(situation, futures, start, work / settings_.rounds, &found, &near);
    found = *best_of(near, &found);
  }
  if (settings_.effort == 1 || found.forecast.done >= left) return found;
  return Search(situation, futures, start, std::min(wanted, allowed) * (settings_.effort - 1),
                std::move(found));
}

}  // namespace muster::scheduler
