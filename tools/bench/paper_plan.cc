#include "tools/bench/paper_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>

#include "scheduler/policies/learned/model.h"

namespace muster::tools {
namespace {

/// The paper's four data sets; ours in place of its real ones, from imported points.
const std::vector<std::string> kDrawn = {"BicycleOrder", "DidiOrders", "TaxiTrajectories",
                                         "Random_1"};
const std::vector<std::string> kImportedPlaces = {"newyork-bicycle", "shenzhen-didi",
                                                  "shenzhen-taxi", "Random_1"};
constexpr std::string_view kHaiti = "haiti";

std::string RandomSetting(int n) { return fmt::format("Random_{}", n); }

class Experiments {
 public:
  explicit Experiments(bool with_imports) : with_imports_(with_imports) {}

  std::vector<PaperExperiment> All() {
    Intervals();
    Limits();
    Background();
    Agents();
    Power();
    Table3And4();
    Table5();
    Table6();
    return std::move(experiments_);
  }

 private:
  PaperExperiment& Add(std::string title, std::string section, std::string note = "") {
    experiments_.push_back({std::move(title), std::move(note), std::move(section), {}});
    return experiments_.back();
  }
  std::vector<std::string> DataSets() const {
    std::vector<std::string> sets = kDrawn;
    if (with_imports_) {
      for (const std::string& name : kImportedPlaces) {
        if (name != "Random_1") sets.push_back(name);
      }
      sets.emplace_back(kHaiti);
    }
    return sets;
  }
  /// Means over the four data sets, the drawn and the imported ones, then each by itself.
  void DataSetLines(PaperExperiment* experiment, const PaperCase& base, const std::string& label,
                    const std::string& published) {
    const auto mean = [&](const std::vector<std::string>& sets, const char* which) {
      PaperLine line{fmt::format("{}, mean of four, {}", label, which), {}, published};
      for (const std::string& set : sets) line.cases.push_back(With(base, set));
      experiment->lines.push_back(std::move(line));
    };
    mean(kDrawn, "drawn places");
    if (with_imports_) mean(kImportedPlaces, "imported places");
    for (const std::string& set : DataSets()) {
      experiment->lines.push_back({fmt::format("{}, {}", label, set), {With(base, set)}, ""});
    }
  }
  static PaperCase With(PaperCase base, const std::string& setting) {
    base.setting = setting;
    return base;
  }

  void Intervals() {
    PaperExperiment& group =
        Add("Group (1): decision interval", "Sec 5.2.1",
            "Missions of 3 h. The paper's figures are means over its four data sets.");
    for (const int interval : {5, 10, 15}) {
      PaperCase base;
      base.interval_min = interval;
      DataSetLines(&group, base, fmt::format("{} min", interval),
                   fmt::format("mean of BicycleOrder+DidiOrders+TaxiTrajectories+Random_1; "
                               "LimitTime 3h; Interval {}min",
                               interval));
    }
  }
  void Limits() {
    PaperExperiment& group =
        Add("Group (2): limit time", "Sec 5.2.2",
            "Decisions every 5 min. The paper's figures are means over its four data sets.");
    for (const int hours : {2, 3, 4}) {
      PaperCase base;
      base.interval_min = 5;
      base.limit_min = 60 * hours;
      DataSetLines(&group, base, fmt::format("{} h", hours),
                   fmt::format("mean of BicycleOrder+DidiOrders+TaxiTrajectories+Random_1; "
                               "Interval 5min; LimitTime {}h",
                               hours));
    }
  }

  /// The mean over some of Random_1 to Random_27, then each.
  void Vary(PaperExperiment* group, const std::string& what, const std::vector<int>& settings,
            const std::string& published) {
    PaperLine mean{what + ", mean", {}, published + "; Interval 10min; LimitTime 3h"};
    for (const int n : settings) mean.cases.push_back(With({}, RandomSetting(n)));
    group->lines.push_back(mean);
    for (const int n : settings) {
      group->lines.push_back(
          {fmt::format("{}, Random_{}", what, n), {With({}, RandomSetting(n))}, ""});
    }
  }
  void Background() {
    PaperExperiment& group = Add("Group (3): area, tasks, charging points, online time",
                                 "Sec 5.2.3", "Decisions every 10 min, missions of 3 h.");
    Vary(&group, "area", {2, 1, 3},
         "area scale: mean of Random_2(20x20)+Random_1(30x30)+Random_3(40x40)");
    Vary(&group, "tasks", {4, 1, 5},
         "tasks number: mean of Random_4(100)+Random_1(120)+Random_5(140)");
    Vary(&group, "charging points", {6, 1, 7},
         "charging points: mean of Random_6(10)+Random_1(20)+Random_7(30)");
    Vary(&group, "online time", {8, 1, 9},
         "online time: mean of Random_8(40min)+Random_1(60min)+Random_9(80min)");
  }
  void Agents() {
    PaperExperiment& group = Add("Group (4): numbers of agents", "Sec 5.2.4",
                                 "Decisions every 10 min, missions of 3 h.");
    Vary(&group, "all agents", {10, 1, 11}, "total agents: mean of Random_10+Random_1+Random_11");
    Vary(&group, "workers", {12, 1, 13},
         "workers: mean of Random_12(30)+Random_1(50)+Random_13(70)");
    Vary(&group, "UAVs", {14, 1, 15}, "UAVs: mean of Random_14(20)+Random_1(30)+Random_15(40)");
    Vary(&group, "vehicles", {16, 1, 17},
         "vehicles: mean of Random_16(10)+Random_1(20)+Random_17(30)");
  }
  void Power() {
    PaperExperiment& group = Add("Group (5): sensing cost and charging power", "Sec 5.2.5",
                                 "Decisions every 10 min, missions of 3 h.");
    Vary(&group, "sensing cost", {1, 18, 19, 20, 21, 22},
         "task cost power: mean over Random_1+Random_18..Random_22");
    Vary(&group, "charging power", {1, 23, 24, 25, 26, 27},
         "charging power: mean over Random_1+Random_23..Random_27");
  }
  void Table3And4() {
    for (const char* section : {"Table 3", "Table 4"}) {
      const bool three = std::string_view(section) == "Table 3";
      PaperExperiment& table = Add(
          three ? "Table 3: HoCs-ILS and HoCs-MPQ" : "Table 4: uniform and hierarchical weights",
          section,
          "Decisions every 10 min, missions of 3 h. New York stands in for BicycleOrder, Shenzhen "
          "for the other two.");
      for (const std::string& set : kDrawn) table.lines.push_back({set, {With({}, set)}, set});
      if (!with_imports_) continue;
      for (std::size_t i = 0; i < 3; ++i) {
        table.lines.push_back({kImportedPlaces[i], {With({}, kImportedPlaces[i])}, kDrawn[i]});
      }
    }
  }
  void Table5() {
    PaperExperiment& table =
        Add("Table 5: disturbances", "Table 5", "Decisions every 10 min, missions of 3 h.");
    constexpr std::array<std::array<const char*, 2>, 5> kNames = {
        {{"none", "base"},
         {"wind", "wind resistance power cost"},
         {"communication", "communication power cost"},
         {"failure", "sudden agent failures"},
         {"match", "packet loss"}}};
    for (const std::string& set : DataSets()) {
      const auto at = std::find(kImportedPlaces.begin(), kImportedPlaces.end(), set);
      const std::string& name =
          at == kImportedPlaces.end()
              ? set
              : kDrawn[static_cast<std::size_t>(at - kImportedPlaces.begin())];
      for (const auto& [disturbance, published] : kNames) {
        PaperCase what = With({}, set);
        what.disturbance = disturbance;
        table.lines.push_back({fmt::format("{}, {}", set, disturbance),
                               {what},
                               fmt::format("{} / {}", name, published)});
      }
    }
  }
  void Table6() {
    PaperExperiment& table = Add("Table 6: larger settings", "Table 6",
                                 "Decisions every 10 min, missions of 3 h; the paper does not say "
                                 "what it used here. Its figure in the first row disagrees with "
                                 "its other figures for Random_1.");
    const auto line = [&](const std::string& set, const char* published) {
      table.lines.push_back({set, {With({}, set)}, published});
    };
    line("Random_1", "area 30x30; tasks 120; charging 20; agents(w,u,v) (50,30,20); density 1:9");
    line("Random_29",
         "area 60x60; tasks 480; charging 80; agents(w,u,v) (200,120,80); density 1:9");
    line("Table6_3",
         "area 60x60; tasks 480; charging 80; agents(w,u,v) (80,48,32); density 1:22.5");
    line("Table6_4",
         "area 150x150; tasks 600; charging 200; agents(w,u,v) (500,300,200); density 1:22.5");
    line("Table6_5",
         "area 90x90; tasks 600; charging 200; agents(w,u,v) (180,108,72); density 1:22.5");
    line("Table6_6",
         "area 150x150; tasks 600; charging 200; agents(w,u,v) (300,180,120); density 1:37.5");
    line("Random_28", "");
  }

  bool with_imports_;
  std::vector<PaperExperiment> experiments_;
};

/// What every case of the main suite is run with.
const std::vector<std::string> kMain = {
    std::string(kUpperBound), "mpq",       "mpq-uniform", "ils",    "kwta", "greedy-sum",
    "greedy-nearest",         "certified", "horizon",     "rollout"};
const std::vector<std::string> kLonger = {"kwta-1", "kwta-5", "kwta-10", "horizon-steps",
                                          "rollout-steps"};

bool Large(const std::string& setting) {
  return setting == "Table6_4" || setting == "Table6_5" || setting == "Table6_6";
}

bool InMain(const PaperCase& what, const std::string& policy) {
  if (std::find(kMain.begin(), kMain.end(), policy) == kMain.end()) return false;
  return !Large(what.setting) || (policy != "ils" && policy != "rollout");
}

bool Wanted(const std::vector<std::string>& only, std::string_view name) {
  return only.empty() || std::find(only.begin(), only.end(), name) != only.end();
}

}  // namespace

std::vector<std::string> LearnedColumns() {
  std::vector<std::string> columns;
  for (const std::string& method : scheduler::learned::kMethodNames) {
    columns.push_back("learned-" + method);
  }
  return columns;
}

std::string PolicyToRun(const PaperRun& run) {
  constexpr std::string_view kColumn = "learned-";
  if (!run.policy.starts_with(kColumn)) return run.policy;
  return fmt::format("learned:models/{}-{}", run.what.setting, run.policy.substr(kColumn.size()));
}

std::vector<std::string> PaperPolicies() {
  std::vector<std::string> policies = kMain;
  policies.insert(policies.end(), kLonger.begin(), kLonger.end());
  return policies;
}

std::string_view NameOf(Availability availability) {
  return availability == Availability::kStrict ? "strict" : "overrun";
}

std::vector<PaperExperiment> PaperExperiments(bool with_imports) {
  return Experiments(with_imports).All();
}

std::vector<PaperRun> PlanRuns(const PaperFilter& filter) {
  std::set<PaperCase> cases;
  for (const PaperExperiment& experiment : PaperExperiments(filter.with_imports)) {
    for (const PaperLine& line : experiment.lines)
      cases.insert(line.cases.begin(), line.cases.end());
  }
  std::vector<std::string> policies = PaperPolicies();
  for (const std::string& policy : filter.policies) {
    // Any policy may be asked for by name.
    if (!Wanted(policies, policy) && !policy.starts_with("learned-")) policies.push_back(policy);
  }
  // Models are for missions as long as those that they were trained on.
  const std::vector<std::string> learned = LearnedColumns();
  const auto add_learned = [&](const PaperCase& what, std::uint64_t seed,
                               std::vector<PaperRun>* to) {
    const PaperCase usual;
    if (what.interval_min != usual.interval_min || what.limit_min != usual.limit_min) return;
    for (const std::string& column : learned) {
      const PaperRun run{what, column, seed};
      const std::string folder = PolicyToRun(run).substr(std::string_view("learned:").size());
      if (Wanted(filter.policies, column) && !filter.longer &&
          std::filesystem::exists(folder + "/model.json")) {
        to->push_back(run);
      }
    }
  };
  std::vector<PaperRun> runs;
  for (std::uint64_t seed = filter.first_seed;
       seed < filter.first_seed + static_cast<std::uint64_t>(filter.seeds); ++seed) {
    for (const Availability availability : {Availability::kStrict, Availability::kOverrun}) {
      if (!Wanted(filter.availability, NameOf(availability))) continue;
      for (PaperCase what : cases) {
        what.availability = availability;
        if (!Wanted(filter.settings, what.setting)) continue;
        for (const std::string& policy : policies) {
          if (!Wanted(filter.policies, policy)) continue;
          if (filter.policies.empty() && InMain(what, policy) == filter.longer) continue;
          runs.push_back({what, policy, seed});
        }
        add_learned(what, seed, &runs);
      }
    }
  }
  return runs;
}

}  // namespace muster::tools
