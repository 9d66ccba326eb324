#include "scheduler/solver/solver.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <utility>

#include "scheduler/solver/branching.h"
#include "scheduler/solver/chains.h"
#include "scheduler/solver/dual.h"
#include "scheduler/solver/matchings.h"
#include "scheduler/solver/plan.h"
#include "scheduler/solver/relaxation.h"
#include "scheduler/solver/windows.h"

namespace muster::scheduler {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::int64_t kWork = 400'000'000;  ///< default limit: this
constexpr std::int64_t kWorkPerArc = 130;    ///< and this for each arc,
/// The relaxation takes so many times its share of that where its bound would be of little use.
constexpr std::int64_t kMoreIfFar = 4;
constexpr std::int64_t kBranchWork = 20'000'000;  ///< of which branching may do that,
constexpr std::int64_t kFarWork = 180'000'000;    ///< or that where the gap is not close enough
/// With more UAVs, partners and sites, chains and windows do what matchings do in less time.
constexpr std::size_t kMatchedRows = 2000;
constexpr double kCloseToLooseBound = 2e-4;  ///< gap, relative
constexpr std::int64_t kSoon = 4;  ///< a search without cliques takes that part of the work
constexpr std::size_t kProvenColumns = 600'000;  ///< that a proof may take
constexpr double kWorthAnotherStart = 1e-4;      ///< gap, relative

class Search {
 public:
  Search(const Instance& instance, const SolverLimits& limits)
      : instance_(instance),
        limits_(limits),
        start_(Clock::now()),
        dual_(instance, limits.threads),
        planner_(instance, dual_),
        relaxation_(instance, &dual_, limits.threads),
        chains_(instance, dual_),
        matchings_(instance, dual_, limits.threads),
        windows_(instance, dual_, &relaxation_) {
    const auto arcs =
        static_cast<std::int64_t>(instance.uav_arcs.size() + instance.partner_arcs.size());
    work_limit_ = limits.work > 0 ? limits.work : kWork + kWorkPerArc * arcs;
  }

  SolverResult Run() {
    auto mark = start_;
    // The rest is for assignments, should the relaxation not end.
    const auto relaxation_deadline =
        limits_.deadline ? start_ + (*limits_.deadline - start_) / 4 * 3 : Clock::time_point::max();
    const std::int64_t for_assignments = work_limit_ / 4;
    const std::int64_t for_relaxation = 3 * for_assignments;
    relaxation_.Solve(
        for_relaxation, [&] { return limits_.deadline && Clock::now() >= relaxation_deadline; },
        limits_.work > 0 ? 0 : kMoreIfFar * for_relaxation);
    work_limit_ = std::max(work_limit_, Work() + for_assignments);
    bound_s_ += Lap(&mark);
    const std::function<bool()> stop = [this] { return Stop(); };
    // The relaxation's own solution, and what the prices suggest when that is fractional.
    Plan plan = relaxation_.Rounded();
    work_ += planner_.Fill(&plan);
    planner_.Weigh(&plan);
    best_ = plan;
    if (relaxation_.anew()) Keep(Plan(*relaxation_.anew()));
    const bool ties = MayNeedMatchings();
    if (!Proven() && ties) Match(&plan, stop);
    if (!Proven() && !IsCloseToLooseBound()) {
      windows_.ImproveFractions(&plan, stop);
      chains_.Improve(&plan, stop);
      windows_.ImproveLosers(&plan, stop);
      Keep(Plan(plan));
      // What these leave is often a partner or a site that all are short of.
      if (!ties && Gap() > kWorthAnotherStart * relaxation_.bound()) Match(&plan, stop);
    }
    if (relaxation_.solved()) Branch();
    if (Gap() > kWorthAnotherStart * relaxation_.bound() && !IsCloseToLooseBound()) {
      StartAgain(stop);
    }
    if (!relaxation_.solved() && !IsCloseToLooseBound()) Branch();
    search_s_ += Lap(&mark);
    return Finish();
  }

 private:
  static double Lap(Clock::time_point* mark) {
    const auto now = Clock::now();
    const double s = std::chrono::duration<double>(now - *mark).count();
    *mark = now;
    return s;
  }
  std::int64_t Work() const {
    return dual_.work() + relaxation_.work() + chains_.work() + windows_.work() +
           matchings_.work() + work_;
  }
  bool Stop() const {
    return Work() > work_limit_ || (limits_.deadline && Clock::now() >= *limits_.deadline);
  }
  void Match(Plan* plan, const std::function<bool()>& stop) {
    matchings_.Improve(plan, stop);
    Keep(Plan(*plan));
  }
  /// Where nearly all columns tie.
  bool MayNeedMatchings() const {
    return relaxation_.anew() ||
           (relaxation_.is_hard() && relaxation_.lp().prices().size() <= kMatchedRows);
  }
  /// Whether the bound, which more work would lower, accounts for most of a gap that is small.
  bool IsCloseToLooseBound() const {
    return relaxation_.anew() && !relaxation_.solved() &&
           Gap() <= kCloseToLooseBound * relaxation_.bound();
  }
  void Keep(Plan&& plan) {
    planner_.Weigh(&plan);
    if (plan.weight > best_.weight) best_ = std::move(plan);
  }
  double Gap() const { return relaxation_.bound() - best_.weight; }
  bool Proven() const {
    const double rest = relaxation_.anew() ? kCloseEnoughAnew * relaxation_.bound() : 0;
    return Gap() <=
           2 * dual_.slack() + kNegligible * static_cast<double>(instance_.uavs.size()) + rest;
  }

  /// What the prices alone suggest.
  void StartAgain(const std::function<bool()>& stop) {
    Plan plan = planner_.Empty();
    work_ += planner_.Fill(&plan);
    chains_.Improve(&plan, stop);
    windows_.ImproveLosers(&plan, stop);
    Keep(std::move(plan));
    if (Gap() <= kWorthAnotherStart * relaxation_.bound()) return;
    // Where all weights are alike, prices hide that some sites are worth more than others.
    dual_.set_prices(relaxation_.first_prices());
    dual_.Evaluate();
    plan = planner_.Empty();
    work_ += planner_.Fill(&plan);
    Keep(std::move(plan));
    dual_.set_prices(relaxation_.prices());
    dual_.Evaluate();
  }

  void Branch() {
    if (Proven() || Stop()) return;
    if (limits_.work <= 0) {
      const bool far = Gap() > kCloseEnough * relaxation_.bound();
      work_limit_ = std::min(work_limit_, Work() + (far ? kFarWork : kBranchWork));
    }
    if (relaxation_.known().size() <= kProofColumns ||
        Gap() > kWorthAnotherStart * relaxation_.bound()) {
      Prove([this] { return Stop(); });
    } else {
      // What is that large need not be exact; a few branches find what windows miss.
      BranchOverKnown([this] { return Stop() || Gap() <= kCloseEnough * relaxation_.bound(); },
                      work_limit_ - Work());
    }
  }

  /// Best assignment among the columns that the linear program knows; returns a bound on all of
  /// these.
  double BranchOverKnown(const std::function<bool()>& stop, std::int64_t work_limit) {
    const double stay = relaxation_.stay_weight();
    Branching branching(relaxation_.lp(), instance_.n_uavs(), dual_.slack(),
                        {stop, [&] { return best_.weight - stay; },
                         [&] {
                           Plan plan = relaxation_.Rounded();
                           work_ += planner_.Fill(&plan);
                           Keep(std::move(plan));
                         }});
    const double bound = branching.Search(relaxation_.bound() - stay, work_limit) + stay;
    work_ += branching.work();
    return bound;
  }

  /// Branches over what the linear program knows, then over every column that a better assignment
  /// may hold: those whose regret at the best prices is within the gap, as what an assignment falls
  /// short of the bound is a sum that each of its columns' regrets is part of. Where that does not
  /// end soon, rows for cliques are added.
  void Prove(const std::function<bool()>& stop) {
    const auto part = [&] { return (work_limit_ - Work()) / kSoon; };
    BranchOverKnown(stop, part());
    // A search over what is listed proves nothing about what is not.
    if (!instance_.rest_level.empty()) return;
    if (Stop() || Proven() || !relaxation_.AddAll(Gap(), kProvenColumns)) return;
    const std::int64_t soon = Work() + part();
    proven_bound_ = BranchOverKnown(stop, part());
    if (Work() >= soon) {
      relaxation_.AddCliques(best_.weight, work_limit_ - Work(), stop);
      proven_bound_ = std::min(proven_bound_, BranchOverKnown(stop, work_limit_ - Work()));
    }
    proven_bound_ = std::max(proven_bound_, best_.weight) + kNegligible;
  }

  SolverResult Finish() {
    SolverResult solution;
    Assignment& assignment = solution.assignment;
    for (const Column& column : best_.column) {
      assignment.uavs.push_back({column.site, column.uav_arc, column.partner_arc});
    }
    for (const Dual::Solo* own : best_.own) {
      assignment.partner_solo.push_back(own == nullptr ? -1 : own->arc);
    }
    assignment.weight = scheduler::WeightOf(instance_, assignment);
    solution.bound = std::max(assignment.weight, std::min(relaxation_.bound(), proven_bound_));
    if (relaxation_.solved()) solution.relaxation = relaxation_.bound();
    solution.work = Work();
    solution.bound_s = bound_s_;
    solution.search_s = search_s_;
    return solution;
  }

  const Instance& instance_;
  SolverLimits limits_;
  Clock::time_point start_;
  Dual dual_;
  Planner planner_;
  Relaxation relaxation_;
  Chains chains_;
  Matchings matchings_;
  Windows windows_;
  std::int64_t work_ = 0, work_limit_ = 0;
  Plan best_;
  double proven_bound_ = std::numeric_limits<double>::infinity();
  double bound_s_ = 0, search_s_ = 0;
};

}  // namespace

SolverResult Solve(const Instance& instance, const SolverLimits& limits) {
  return Search(instance, limits).Run();
}

}  // namespace muster::scheduler
