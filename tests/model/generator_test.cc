#include "model/generator.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "base/check.h"
#include "model/scenario_json.h"

namespace muster {
namespace {

std::string Shared(const std::string& path) {
  const char* root = std::getenv("MUSTER_SHARED");
  return (root != nullptr ? std::string(root) : std::string(MUSTER_SHARED_DEFAULT)) + "/" + path;
}

/// Fields of a CSV line; quotes only around whole fields, as in that table.
std::vector<std::string> Fields(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else if (c != '\r') {
      fields.back() += c;
    }
  }
  return fields;
}

DrawRange RangeOf(const std::string& text) {
  DrawRange range;
  if (std::sscanf(text.c_str(), "[%lf,%lf]", &range.low, &range.high) == 2) return range;
  if (std::sscanf(text.c_str(), ">%lf", &range.low) == 1) return {range.low, kUpToLimit};
  EXPECT_EQ(std::sscanf(text.c_str(), "%lf", &range.low), 1) << text;
  return Always(range.low);
}

TEST(Generator, PresetsAreThePapersTable) {
  std::ifstream in(Shared("paper/datasets.csv"));
  if (!in) GTEST_SKIP() << "no " << Shared("paper/datasets.csv");
  std::string line;
  std::getline(in, line);
  std::size_t n = 0;
  for (; std::getline(in, line); ++n) {
    const std::vector<std::string> f = Fields(line);
    ASSERT_EQ(f.size(), 11u) << line;
    ASSERT_LT(n, Presets().size());
    const GeneratorSettings& preset = Presets()[n];
    EXPECT_EQ(preset.name, f[0]);
    EXPECT_EQ(preset.width_km, std::stod(f[1])) << line;
    EXPECT_EQ(preset.height_km, std::stod(f[2])) << line;
    EXPECT_EQ(preset.tasks, std::stoi(f[3])) << line;
    EXPECT_EQ(preset.charging_points, std::stoi(f[4])) << line;
    EXPECT_EQ(preset.online_min, RangeOf(f[5])) << line;
    EXPECT_EQ(preset.workers, std::stoi(f[6])) << line;
    EXPECT_EQ(preset.uavs, std::stoi(f[7])) << line;
    EXPECT_EQ(preset.vehicles, std::stoi(f[8])) << line;
    EXPECT_EQ(preset.task_cost_km, RangeOf(f[9])) << line;
    EXPECT_EQ(preset.charge_km_per_min, RangeOf(f[10])) << line;
  }
  EXPECT_EQ(n, 32u);
  EXPECT_EQ(Presets().size(), 32u);
}

TEST(Generator, RandomOneIsAsThePaperSays) {
  const Scenario s = Generate(PresetByName("Random_1"), 7);
  EXPECT_EQ(s.name, "Random_1");
  EXPECT_EQ(s.seed, 7u);
  EXPECT_EQ(s.width_m, 30'000);
  EXPECT_EQ(s.height_m, 30'000);
  EXPECT_EQ(s.rules.interval_us, 10 * kMinuteUs);
  EXPECT_EQ(s.rules.limit_us, 180 * kMinuteUs);
  EXPECT_EQ(s.uavs.size(), 30u);
  EXPECT_EQ(s.workers.size(), 50u);
  EXPECT_EQ(s.vehicles.size(), 20u);
  EXPECT_EQ(s.tasks.size(), 120u);
  EXPECT_EQ(s.charging_points.size(), 20u);
  for (const AgentKind kind : kAgentKinds) {
    for (const AgentSpec& agent : s.agents(kind)) {
      EXPECT_EQ(agent.online_until_us - agent.online_from_us, 60 * kMinuteUs);
      EXPECT_LE(agent.online_until_us, 180 * kMinuteUs);
      EXPECT_EQ(std::fmod(agent.at.x_m, 1000), 500);
      EXPECT_EQ(std::fmod(agent.at.y_m, 1000), 500);
    }
  }
  for (const AgentSpec& uav : s.uavs) {
    EXPECT_EQ(uav.speed_m_s, 1000.0 / 60);
    EXPECT_EQ(uav.range_full_m, 30'000);
    EXPECT_EQ(uav.range_m, 30'000);
  }
  for (const AgentSpec& worker : s.workers) EXPECT_EQ(worker.speed_m_s, 500.0 / 60);
  for (const AgentSpec& vehicle : s.vehicles) {
    EXPECT_EQ(vehicle.speed_m_s, 12.5);
    EXPECT_EQ(vehicle.charge_rate_m_s, 10'000.0 / 60);
  }
  for (const Task& task : s.tasks) EXPECT_EQ(task.cost_m, 3000);
  for (const ChargingPoint& point : s.charging_points) EXPECT_EQ(point.capacity, 1);
}

TEST(Generator, EveryPresetIsAValidFile) {
  for (const GeneratorSettings& preset : Presets()) {
    const std::string text = ScenarioToJson(Generate(preset, 3));
    EXPECT_EQ(ScenarioToJson(ParseScenario(text, preset.name)), text);
  }
}

TEST(Generator, SameSeedSameFileOtherSeedOtherFile) {
  const GeneratorSettings& preset = PresetByName("Random_1");
  EXPECT_EQ(ScenarioToJson(Generate(preset, 7)), ScenarioToJson(Generate(preset, 7)));
  EXPECT_NE(ScenarioToJson(Generate(preset, 7)), ScenarioToJson(Generate(preset, 8)));
}

bool Same(const AgentSpec& a, const AgentSpec& b) {
  return a.at == b.at && a.speed_m_s == b.speed_m_s && a.range_m == b.range_m &&
         a.charge_rate_m_s == b.charge_rate_m_s && a.online_from_us == b.online_from_us &&
         a.online_until_us == b.online_until_us;
}

TEST(Generator, OneMoreItemLeavesTheOthersAsTheyWere) {
  GeneratorSettings settings = PresetByName("Random_1");
  const Scenario before = Generate(settings, 5);
  ++settings.uavs;
  ++settings.workers;
  ++settings.vehicles;
  ++settings.tasks;
  ++settings.charging_points;
  const Scenario after = Generate(settings, 5);
  for (const AgentKind kind : kAgentKinds) {
    for (std::size_t i = 0; i < before.agents(kind).size(); ++i) {
      EXPECT_TRUE(Same(before.agents(kind)[i], after.agents(kind)[i])) << i;
    }
  }
  for (std::size_t i = 0; i < before.tasks.size(); ++i) {
    EXPECT_EQ(before.tasks[i].at, after.tasks[i].at);
  }
  for (std::size_t i = 0; i < before.charging_points.size(); ++i) {
    EXPECT_EQ(before.charging_points[i].at, after.charging_points[i].at);
  }
}

TEST(Generator, AnotherCostOrPowerLeavesPlacesAndTimesAsTheyWere) {
  const Scenario one = Generate(PresetByName("Random_1"), 5);
  const Scenario cost = Generate(PresetByName("Random_20"), 5);
  const Scenario power = Generate(PresetByName("Random_25"), 5);
  for (std::size_t i = 0; i < one.tasks.size(); ++i) EXPECT_EQ(one.tasks[i].at, cost.tasks[i].at);
  for (std::size_t i = 0; i < one.vehicles.size(); ++i) {
    EXPECT_EQ(one.vehicles[i].at, power.vehicles[i].at);
    EXPECT_EQ(one.vehicles[i].online_from_us, power.vehicles[i].online_from_us);
  }
}

TEST(Generator, RangesAreDrawnPerItemUniformly) {
  GeneratorSettings settings = PresetByName("Random_20");
  settings.tasks = 20'000;
  settings.vehicles = 20'000;
  settings.charge_km_per_min = {2, 6};
  const Scenario s = Generate(settings, 1);
  double low = 1e9, high = 0, sum = 0;
  for (const Task& task : s.tasks) {
    EXPECT_EQ(task.cost_m, std::round(task.cost_m));
    low = std::min(low, task.cost_m);
    high = std::max(high, task.cost_m);
    sum += task.cost_m;
  }
  EXPECT_EQ(low, 2000);  // one of 1001 values in 20,000 draws
  EXPECT_EQ(high, 3000);
  EXPECT_NEAR(sum / 20'000, 2500, 10.3);  // five standard errors
  sum = 0;
  for (const AgentSpec& vehicle : s.vehicles) {
    const double km_per_min = vehicle.charge_rate_m_s * 0.06;
    EXPECT_TRUE(km_per_min > 2 - 1e-9 && km_per_min < 6 + 1e-9) << km_per_min;
    sum += km_per_min;
  }
  EXPECT_NEAR(sum / 20'000, 4, 0.041);
}

TEST(Generator, CellsAreUniform) {
  GeneratorSettings settings = PresetByName("DidiOrders");
  settings.tasks = 90'000;
  std::map<std::pair<double, double>, int> count;
  for (const Task& task : Generate(settings, 2).tasks) ++count[{task.at.x_m, task.at.y_m}];
  EXPECT_EQ(count.size(), 90u);
  double chi2 = 0;
  for (const auto& [cell, n] : count) chi2 += (n - 1000.0) * (n - 1000.0) / 1000;
  EXPECT_LT(chi2, 156);  // 89 degrees of freedom, five standard deviations above the mean
}

TEST(Generator, ContinuousPlacesAreWholeMetresInTheArea) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.placement = Placement::kContinuous;
  settings.width_km = 1.5004;
  settings.tasks = 5000;
  std::set<double> xs;
  for (const Task& task : Generate(settings, 2).tasks) {
    EXPECT_EQ(task.at.x_m, std::round(task.at.x_m));
    EXPECT_LE(task.at.x_m, 1500.4);
    xs.insert(task.at.x_m);
  }
  EXPECT_GT(xs.size(), 1400u);  // of 1501
}

TEST(Generator, UptimeWithinLimitOrAnyTime) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.workers = 20'000;
  const auto mean_from = [&](Uptime uptime, TimeUs most) {
    settings.uptime = uptime;
    double sum = 0;
    for (const AgentSpec& worker : Generate(settings, 4).workers) {
      EXPECT_GE(worker.online_from_us, 0);
      EXPECT_LE(worker.online_from_us, most);
      EXPECT_EQ(worker.online_from_us % (kMinuteUs / 100), 0);
      sum += ToMinutes(worker.online_from_us);
    }
    return sum / 20'000;
  };
  EXPECT_NEAR(mean_from(Uptime::kWithinLimit, 120 * kMinuteUs), 60, 1.3);
  EXPECT_NEAR(mean_from(Uptime::kAnyTime, 180 * kMinuteUs), 90, 1.9);
}

TEST(Generator, AtLeastSeventyMinutesMeansUpToTheLimit) {
  GeneratorSettings settings = PresetByName("BicycleOrder");
  settings.workers = 20'000;
  double sum = 0;
  for (const AgentSpec& worker : Generate(settings, 4).workers) {
    const TimeUs online = worker.online_until_us - worker.online_from_us;
    EXPECT_GE(online, 70 * kMinuteUs);
    EXPECT_LE(worker.online_until_us, 180 * kMinuteUs);
    sum += ToMinutes(online);
  }
  EXPECT_NEAR(sum / 20'000, 125, 1.2);
  settings.rules.limit_us = 60 * kMinuteUs;  // shorter than the least: online all the time
  for (const AgentSpec& worker : Generate(settings, 4).workers) {
    EXPECT_EQ(worker.online_from_us, 0);
    EXPECT_EQ(worker.online_until_us, 70 * kMinuteUs);
  }
}

TEST(Generator, StartFraction) {
  GeneratorSettings settings = PresetByName("Random_1");
  settings.start_fraction = {0.5, 1};
  settings.uavs = 2000;
  for (const AgentSpec& uav : Generate(settings, 4).uavs) {
    EXPECT_GE(uav.range_m, 15'000);
    EXPECT_LE(uav.range_m, 30'000);
  }
}

TEST(Generator, ScaleKeepsTheDensity) {
  const GeneratorSettings four = Scaled(PresetByName("Random_1"), 4);
  EXPECT_EQ(four.width_km, 60);
  EXPECT_EQ(four.height_km, 60);
  EXPECT_EQ(four.uavs, 120);
  EXPECT_EQ(four.workers, 200);
  EXPECT_EQ(four.vehicles, 80);
  EXPECT_EQ(four.tasks, 480);
  EXPECT_EQ(four.charging_points, 80);
  const GeneratorSettings tiny = Scaled(PresetByName("Random_1"), 0.01);
  EXPECT_EQ(tiny.vehicles, 1);  // 0.2, but never none
  EXPECT_EQ(Generate(Scaled(PresetByName("Random_1"), 2), 1).width_m, 42'426);
}

TEST(Generator, CutCellsHaveTheirCentreInTheArea) {
  EXPECT_EQ(CellCentre(0, 0, 2500, 800), (Point{500, 400}));
  EXPECT_EQ(CellCentre(2, 0, 2500, 800), (Point{2250, 400}));
}

TEST(Generator, BadSettingsAreInputErrors) {
  EXPECT_THROW(PresetByName("Random_30"), InputError);
  GeneratorSettings settings = PresetByName("Random_1");
  settings.uavs = 0;
  EXPECT_THROW(Generate(settings, 1), InputError);
  settings = PresetByName("Random_1");
  settings.width_km = -1;
  EXPECT_THROW(Generate(settings, 1), InputError);
  settings.width_km = std::nan("");
  EXPECT_THROW(Generate(settings, 1), InputError);
  settings = PresetByName("Random_1");
  settings.rules.tick_us = 7 * kSecondUs;
  EXPECT_THROW(Generate(settings, 1), InputError);
}

}  // namespace
}  // namespace muster
