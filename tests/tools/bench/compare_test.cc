#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/check.h"
#include "tools/bench/compare_command.h"

namespace muster::tools {
namespace {

/// So many of 10 tasks in each mission.
std::vector<ComparedMission> Missions(const std::vector<int>& done) {
  std::vector<ComparedMission> missions;
  for (const int n : done) {
    missions.push_back({"seed " + std::to_string(missions.size()), n, 10, 600, 0.002});
  }
  return missions;
}

/// By hand: the differences are 1, 2, 0, 1, 1 tasks of 10, so 10 points on average, with a standard
/// error of 7.0711 / sqrt(5) = 3.162 points; times 2.776 that is 8.8.
TEST(Compare, SaysHowMuchMoreAndWhetherThatMayBeChance) {
  const Comparison clear = {{"a", "b"}, {Missions({5, 6, 7, 5, 6}), Missions({6, 8, 7, 6, 7})}};
  const std::string text = ComparisonText(clear);
  EXPECT_NE(text.find("b against a: +10.0 points of completion (95 % interval +1.2 to +18.8). It "
                      "does more tasks in 4 of 5 missions, as many in 1, fewer in 0."),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("29 of 50    58.0"), std::string::npos) << text;
  EXPECT_NEAR(ToJson(clear)["policies"][1]["points_more_95"][0].get<double>(), 1.22, 0.01);

  const Comparison chance = {{"a", "b"}, {Missions({5, 6, 7, 5, 6}), Missions({9, 4, 7, 6, 5})}};
  EXPECT_NE(ComparisonText(chance).find(": may be chance)"), std::string::npos);
  const Comparison few = {{"a", "b"}, {Missions({5, 6}), Missions({9, 9})}};
  EXPECT_NE(ComparisonText(few).find("too few missions"), std::string::npos);
  EXPECT_TRUE(ToJson(few)["policies"][1]["points_more_95"].is_null());
  const Comparison same = {{"a", "b"}, {Missions({5, 6, 7, 5, 6}), Missions({5, 6, 7, 5, 6})}};
  EXPECT_NE(ComparisonText(same).find("+0.0 to +0.0: may be chance"), std::string::npos)
      << ComparisonText(same);
}

std::string RefusalOf(const std::vector<const char*>& arguments) {
  std::vector<const char*> argv = {"compare"};
  argv.insert(argv.end(), arguments.begin(), arguments.end());
  try {
    CompareCommand(static_cast<int>(argv.size()), argv.data());
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Compare, BadInputIsNamedBeforeAnythingIsFlown) {
  EXPECT_NE(RefusalOf({"horizon"}).find("two or more policies"), std::string::npos);
  EXPECT_NE(RefusalOf({"horizon", "nope"}).find("found nope"), std::string::npos);
  EXPECT_NE(RefusalOf({"horizon", "mpq", "--seeds", "0"}).find("--seeds"), std::string::npos);
  EXPECT_NE(RefusalOf({"horizon", "mpq", "--scenarios", "/nowhere.json"}).find("/nowhere.json"),
            std::string::npos);
  EXPECT_NE(RefusalOf({"horizon", "mpq", "--preset", "X"}).find('X'), std::string::npos);
}

}  // namespace
}  // namespace muster::tools
