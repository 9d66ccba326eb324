#include "scheduler/policies/horizon/regions.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "base/geometry.h"
#include "base/grid_index.h"
#include "base/index.h"
#include "scheduler/policies/horizon/pairs.h"
#include "scheduler/solver/parallel.h"
#include "scheduler/solver/solver.h"

namespace muster::scheduler {
namespace {

/// What lies within so many long ways of a cut is matched again. Nine of ten pairs have shorter
/// ways than a long one.
constexpr double kWaysFromCut = 4;
constexpr std::size_t kShorter = 9, kOfPairs = 10;
/// Steps of the solver for each UAV of a region; more raises the weight by less than 1e-4.
constexpr std::int64_t kWorkPerUav = 8000;
constexpr std::int64_t kLeastWork = 2'000'000;
/// Regions suit where no more than this share of the pairs is found across all cuts.
constexpr double kFewAcross = 0.02;

/// Where `size` elements are cut into n parts; `shifted`: into n + 1 parts, of which the first and
/// the last are half as large as the others.
std::vector<std::size_t> CutsOf(std::size_t size, std::size_t n, bool shifted) {
  std::vector<std::size_t> cuts;
  for (std::size_t i = shifted ? 0 : 1; i < n; ++i) {
    cuts.push_back(shifted ? size * (2 * i + 1) / (2 * n) : size * i / n);
  }
  return cuts;
}

std::size_t Above(const std::vector<double>& cuts, double x) {
  return static_cast<std::size_t>(std::upper_bound(cuts.begin(), cuts.end(), x) - cuts.begin());
}

bool IsNear(const std::vector<double>& cuts, double x, double metres) {
  const auto cut = std::lower_bound(cuts.begin(), cuts.end(), x - metres);
  return cut != cuts.end() && *cut <= x + metres;
}

/// What can still be matched.
struct Pool {
  PerKind<std::vector<char>> agents;  ///< [participants]
  OpenSites open;

  /// A pair's members and place are in the pool from now on, or no longer.
  void Set(const Match& match, bool in) {
    agents.uavs[At(match.uav)] = agents[PartnerKindOf(match)][At(match.partner)] = in;
    if (match.charging) {
      open.place[At(match.site)] += in ? 1 : -1;
    } else {
      open.task[At(match.site)] = in;
    }
  }
};

/// A region's share of a pool.
struct Part {
  Participants participants;
  PerKind<std::vector<std::int32_t>> index;  ///< of these among all participants
  std::vector<std::int32_t> tasks;
  std::vector<std::pair<std::int32_t, std::int32_t>> places;  ///< charging point, free places
  std::vector<Match> matches;                                 ///< the heaviest that are known
  std::int64_t candidates = 0;
};

double WeightOf(const std::vector<Match>& matches) {
  double weight = 0;
  for (const Match& match : matches) weight += match.weight;
  return weight;
}

class RegionalMatching {
 public:
  RegionalMatching(const Situation& situation, const Participants& participants,
                   const OpenSites& open, const HorizonSettings& settings, int threads)
      : situation_(situation),
        site_(*situation.site),
        participants_(participants),
        open_(open),
        settings_(settings),
        threads_(threads) {
    open_.outlook = OutlookOf(situation, open);
  }

  std::optional<std::vector<Match>> Run(std::size_t n, std::int64_t* candidates) {
    const Regions regions(participants_.uavs, n, false);
    std::vector<Part> parts = Deal(Rest(), regions);
    MatchAll(&parts);
    Collect(&parts);
    MatchAgain(regions, Regions(participants_.uavs, n, true));
    if (candidates != nullptr) *candidates = candidates_;
    if (!MatchAcross()) return {};
    std::sort(matches_.begin(), matches_.end(),
              [](const Match& a, const Match& b) { return a.uav < b.uav; });
    return std::move(matches_);
  }

 private:
  Point UavAt(const Match& match) const { return participants_.uavs[At(match.uav)].at; }
  Point PartnerAt(const Match& match) const {
    return participants_[PartnerKindOf(match)][At(match.partner)].at;
  }

  /// What no pair uses.
  Pool Rest() const {
    Pool pool;
    for (const AgentKind kind : kAgentKinds) {
      pool.agents[kind].assign(participants_[kind].size(), 1);
    }
    pool.open = open_;
    for (const Match& match : matches_) pool.Set(match, false);
    return pool;
  }

  /// Leaves in the pool what is where keep(place).
  template <class Keep>
  void Narrow(Pool* pool, const Keep& keep) const {
    for (const AgentKind kind : kAgentKinds) {
      for (std::size_t i = 0; i < participants_[kind].size(); ++i) {
        if (!keep(participants_[kind][i].at)) pool->agents[kind][i] = 0;
      }
    }
    for (std::size_t x = 0; x < site_.tasks.size(); ++x) {
      if (pool->open.task[x] && !keep(site_.tasks[x].at)) pool->open.task[x] = 0;
    }
    for (std::size_t y = 0; y < site_.charging_points.size(); ++y) {
      if (!keep(site_.charging_points[y].at)) pool->open.place[y] = 0;
    }
  }

  std::vector<Part> Deal(const Pool& pool, const Regions& regions) const {
    std::vector<Part> parts(regions.size());
    for (const AgentKind kind : kAgentKinds) {
      for (std::size_t i = 0; i < participants_[kind].size(); ++i) {
        if (!pool.agents[kind][i]) continue;
        Part& part = parts[regions.Of(participants_[kind][i].at)];
        part.participants[kind].push_back(participants_[kind][i]);
        part.index[kind].push_back(static_cast<std::int32_t>(i));
      }
    }
    for (std::size_t x = 0; x < site_.tasks.size(); ++x) {
      if (!pool.open.task[x]) continue;
      parts[regions.Of(site_.tasks[x].at)].tasks.push_back(static_cast<std::int32_t>(x));
    }
    for (std::size_t y = 0; y < site_.charging_points.size(); ++y) {
      if (pool.open.place[y] <= 0) continue;
      parts[regions.Of(site_.charging_points[y].at)].places.emplace_back(
          static_cast<std::int32_t>(y), pool.open.place[y]);
    }
    return parts;
  }

  /// `open` has nothing open, before and after.
  void MatchPart(Part* part, OpenSites* open) const {
    for (const std::int32_t x : part->tasks) open->task[At(x)] = 1;
    for (const auto& [y, places] : part->places) open->place[At(y)] = places;
    const PossiblePairs pairs = FindPairs(situation_, part->participants, *open, settings_);
    for (const std::int32_t x : part->tasks) open->task[At(x)] = 0;
    for (const auto& [y, places] : part->places) open->place[At(y)] = 0;
    part->candidates = CountNodes(pairs.instance);
    SolverLimits limits;
    limits.work = std::max(kLeastWork,
                           kWorkPerUav * static_cast<std::int64_t>(part->participants.uavs.size()));
    std::vector<Match> found =
        MatchesOf(pairs, part->participants, Solve(pairs.instance, limits).assignment);
    if (WeightOf(found) < WeightOf(part->matches)) return;
    for (Match& match : found) {
      match.uav = part->index.uavs[At(match.uav)];
      match.partner = part->index[PartnerKindOf(match)][At(match.partner)];
    }
    part->matches = std::move(found);
  }

  void MatchAll(std::vector<Part>* parts) const {
    OpenSites closed = open_;
    std::fill(closed.task.begin(), closed.task.end(), 0);
    std::fill(closed.place.begin(), closed.place.end(), 0);
    std::atomic<std::size_t> next = 0;
    const auto run = [&] {
      OpenSites open = closed;
      for (std::size_t k = next++; k < parts->size(); k = next++) MatchPart(&(*parts)[k], &open);
    };
    if (threads_ > 1) {
      AtOnce(run, run);
    } else {
      run();
    }
  }

  void Collect(std::vector<Part>* parts) {
    for (const Part& part : *parts) {
      matches_.insert(matches_.end(), part.matches.begin(), part.matches.end());
      candidates_ += part.candidates;
    }
  }

  /// Matches what is close to the cuts once more, in the shifted regions.
  void MatchAgain(const Regions& regions, const Regions& shifted) {
    const double metres = kWaysFromCut * LongWay();
    const auto is_near = [&](Point at) { return regions.IsNearCut(at, metres); };
    Pool pool = Rest();
    Narrow(&pool, is_near);
    std::vector<Match> kept;
    std::vector<std::vector<Match>> loose(shifted.size());
    for (const Match& match : matches_) {
      const Point uav = UavAt(match), partner = PartnerAt(match), place = PlaceOf(site_, match);
      const std::size_t region = shifted.Of(place);
      if ((is_near(uav) || is_near(partner) || is_near(place)) && shifted.Of(uav) == region &&
          shifted.Of(partner) == region) {
        loose[region].push_back(match);
        pool.Set(match, true);
      } else {
        kept.push_back(match);
      }
    }
    std::vector<Part> parts = Deal(pool, shifted);
    for (std::size_t k = 0; k < parts.size(); ++k) parts[k].matches = std::move(loose[k]);
    MatchAll(&parts);
    matches_ = std::move(kept);
    Collect(&parts);
  }

  /// Metres in a straight line. A pair counts by the longer of its two ways.
  double LongWay() const {
    std::vector<double> ways_m;
    for (const Match& match : matches_) {
      const Point place = PlaceOf(site_, match);
      ways_m.push_back(std::max(Distance(UavAt(match), place), Distance(PartnerAt(match), place)));
    }
    if (ways_m.empty()) return 0;
    const auto at =
        ways_m.begin() + static_cast<std::ptrdiff_t>(ways_m.size() * kShorter / kOfPairs);
    std::nth_element(ways_m.begin(), at, ways_m.end());
    return *at;
  }

  /// Matches what is left, in one piece. False: it made so many pairs that regions do not suit.
  bool MatchAcross() {
    Pool pool = Rest();
    KeepReached(&pool.open, pool.agents.uavs);
    std::vector<Part> parts = Deal(pool, Regions(participants_.uavs, 1, false));
    MatchAll(&parts);
    const auto n = static_cast<double>(matches_.size());
    if (static_cast<double>(parts.front().matches.size()) > kFewAcross * n) return false;
    Collect(&parts);
    return true;
  }

  /// Closes what none of the UAVs can reach.
  void KeepReached(OpenSites* open, const std::vector<char>& uavs) const {
    std::vector<Point> at;
    std::vector<std::size_t> which;  // charging points count after all tasks
    const std::size_t n_tasks = open->task.size();
    for (std::size_t x = 0; x < n_tasks; ++x) {
      if (!open->task[x]) continue;
      at.push_back(site_.tasks[x].at);
      which.push_back(x);
    }
    for (std::size_t y = 0; y < open->place.size(); ++y) {
      if (open->place[y] <= 0) continue;
      at.push_back(site_.charging_points[y].at);
      which.push_back(n_tasks + y);
    }
    std::vector<char> is_reached(n_tasks + open->place.size());
    const GridIndex sites(at);
    for (std::size_t u = 0; u < uavs.size(); ++u) {
      if (!uavs[u]) continue;
      const Participant& uav = participants_.uavs[u];
      sites.Within(uav.at, uav.reach_m(),
                   [&](std::int32_t i, Point, double) { is_reached[which[At(i)]] = 1; });
    }
    for (std::size_t x = 0; x < n_tasks; ++x) open->task[x] &= is_reached[x];
    for (std::size_t y = 0; y < open->place.size(); ++y) {
      if (!is_reached[n_tasks + y]) open->place[y] = 0;
    }
  }

  const Situation& situation_;
  const Site& site_;
  const Participants& participants_;
  OpenSites open_;
  const HorizonSettings& settings_;
  int threads_;
  std::vector<Match> matches_;
  std::int64_t candidates_ = 0;
};

}  // namespace

Regions::Regions(const std::vector<Participant>& uavs, std::size_t n, bool shifted) {
  std::vector<Point> at;
  at.reserve(uavs.size());
  for (const Participant& uav : uavs) at.push_back(uav.at);
  std::sort(at.begin(), at.end(),
            [](Point a, Point b) { return a.x_m != b.x_m ? a.x_m < b.x_m : a.y_m < b.y_m; });
  std::vector<std::size_t> ends = CutsOf(at.size(), n, shifted);
  for (const std::size_t cut : ends) x_m_.push_back(at[cut].x_m);
  ends.push_back(at.size());
  std::size_t begin = 0;
  for (const std::size_t end : ends) {
    std::vector<double> y_m;
    for (std::size_t i = begin; i < end; ++i) y_m.push_back(at[i].y_m);
    std::sort(y_m.begin(), y_m.end());
    y_m_.emplace_back();
    for (const std::size_t cut : CutsOf(y_m.size(), n, shifted)) y_m_.back().push_back(y_m[cut]);
    first_.push_back(size_);
    size_ += y_m_.back().size() + 1;
    begin = end;
  }
}

std::size_t Regions::Of(Point at) const {
  const std::size_t column = Above(x_m_, at.x_m);
  return first_[column] + Above(y_m_[column], at.y_m);
}

bool Regions::IsNearCut(Point at, double metres) const {
  return IsNear(x_m_, at.x_m, metres) || IsNear(y_m_[Above(x_m_, at.x_m)], at.y_m, metres);
}

std::optional<std::vector<Match>> PairsByRegion(const Situation& situation,
                                                const Participants& participants,
                                                const OpenSites& open,
                                                const HorizonSettings& settings, std::size_t n,
                                                int threads, std::int64_t* candidates) {
  return RegionalMatching(situation, participants, open, settings, threads).Run(n, candidates);
}

}  // namespace muster::scheduler
