// What every policy decides in random situations, as it was when this was written: the number of
// actions that are not staying, the weight, and a hash of all. Where a change is meant to move
// decisions, the new lines (printed by a failure) and the reason belong in its commit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <ostream>
#include <string>

#include "scheduler/policies/registry.h"
#include "tests/scheduler/situation_builder.h"

namespace muster::scheduler {
namespace {

/// FNV-1a, 32 bits.
std::uint32_t HashOf(const std::string& text) {
  std::uint32_t hash = 2166136261u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return hash;
}

struct PolicyCase {
  const char* policy;
  const char* few;    ///< agents in a small area, where much ties
  const char* many;   ///< in a larger one
  const char* scant;  ///< more agents than there is to do
};
void PrintTo(const PolicyCase& c, std::ostream* out) { *out << c.policy; }

class Decisions : public ::testing::TestWithParam<PolicyCase> {
 protected:
  static std::string Told(const testing::RandomSize& size, std::uint64_t first, int n) {
    const auto policy = MakePolicy(GetParam().policy);
    std::string text;
    double weight = 0;
    std::int64_t moves = 0;
    for (int i = 0; i < n; ++i) {
      const std::uint64_t seed = first + static_cast<std::uint64_t>(i);
      Rules rules;
      if (seed % 3 == 1) rules.availability = Availability::kOverrun;
      rules.mean_over_all = seed % 4 == 3;
      const Decision decision = policy->Decide(testing::RandomSituation(seed, size, rules));
      for (const Action& a : decision.actions) {
        moves += !IsStay(a.kind);
        text += fmt::format("{} {:.9g} {:.9g} {:.9g};", ToString(a), a.to.x_m, a.to.y_m, a.weight);
      }
      weight += decision.weight;
      text += fmt::format("{:.9g} {}\n", decision.bound, decision.candidates);
    }
    return fmt::format("{} {:.9g} {:08x}", moves, weight, HashOf(text));
  }
};

TEST_P(Decisions, AreThoseTheyWere) {
  const PolicyCase& c = GetParam();
  const bool slow = std::string(c.policy).starts_with("rollout");
  EXPECT_EQ(Told({5, 6, 4, 9, 4, 5}, 1000, slow ? 4 : 30), c.few);
  EXPECT_EQ(Told({14, 18, 9, 26, 8, 20}, 2000, slow ? 1 : 10), c.many);
  EXPECT_EQ(Told({9, 10, 7, 4, 3, 9}, 3000, slow ? 2 : 20), c.scant);
}

const PolicyCase kDecisionCases[] = {
    {"certified", "124 9104.56684 c183641f", "134 7438.14207 ee6253e9", "115 6155.59511 6a64abb1"},
    {"mpq", "123 8677.24903 e08a51b7", "133 7122.77443 9b51d875", "113 6096.774 4189853d"},
    {"mpq-uniform", "125 387.2532 27aebdec", "129 346.916852 286bf83b", "108 396.119111 68fbcf3a"},
    {"ils", "125 8740.11948 a8b8363d", "133 7022.56091 89d52327", "113 6090.72292 502d06d9"},
    {"kwta", "100 6042.11343 532277d8", "84 5415.66474 7bc2cd0d", "83 5332.70187 ac8fd2d2"},
    {"greedy-sum", "340 0 b3d02967", "344 0 50664abe", "402 0 06431a66"},
    {"greedy-nearest", "336 0 63a6ff8b", "337 0 d58df81b", "401 0 77565e25"},
    {"horizon", "142 126.973741 c146ffce", "106 70.8080587 e917ba04", "88 65.7694124 2f9e8bcf"},
    {"horizon-steps", "142 126.973741 f25e40ee", "128 59.4196928 45e92656",
     "99 60.459591 cace4bf2"},
    {"horizon-without-charge-by-use", "150 92.528215 d51a0c4c", "115 62.2254883 3379067d",
     "120 49.3318884 745c9d9a"},
    {"neighbours", "150 123.133543 b8c82d4a", "94 53.0303311 0672b110", "91 57.2284242 f8848e58"},
    {"neighbours:reach=3:loss=0.2", "135 120.06723 ff12b2f4", "69 42.1851232 a6b2e593",
     "90 44.9427854 67fd6919"},
    {"rollout", "14 11.2416951 398e4090", "8 5.68144762 036b134e", "11 11.1272588 c538c53f"},
};

INSTANTIATE_TEST_SUITE_P(, Decisions, ::testing::ValuesIn(kDecisionCases), [](const auto& test) {
  std::string name = test.param.policy;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
  return name;
});

}  // namespace
}  // namespace muster::scheduler
