#include "world/ballot.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace muster::world {
namespace {

/// A proposal for decision 3 with so many actions of weight 1 each.
proposal_t Proposal(int actions, std::int32_t decision = 3) {
  proposal_t proposal{};
  proposal.schedule.decision = decision;
  proposal.schedule.weight = actions;
  proposal.schedule.bound = std::numeric_limits<double>::quiet_NaN();
  proposal.schedule.actions.resize(static_cast<std::size_t>(actions));
  proposal.schedule.n = actions;
  return proposal;
}

bool AllSound(const proposal_t&) { return true; }

class BallotTest : public ::testing::Test {
 protected:
  static constexpr TimeUs kAsked = 10 * kSecondUs;
  void Open(TimeUs now_us = kAsked) { three_.Open(now_us), two_.Open(now_us); }
  Ballot three_{{"scheduler-1", "scheduler-2", "scheduler-3"}};
  Ballot two_{{"scheduler-1", "scheduler-2"}};
};

TEST_F(BallotTest, TheTimeThatItTookAndWhatIsToldAreNoDifference) {
  proposal_t one = Proposal(2), other = Proposal(2);
  other.header.sender = other.schedule.header.sender = "scheduler-2";
  other.schedule.solve_us = 5000;
  other.events.resize(1);
  other.n_events = 1;
  EXPECT_EQ(DigestOf(one), DigestOf(other));
  other.schedule.actions[1].weight = 1e-9;
  EXPECT_NE(DigestOf(one), DigestOf(other));
  other = one;
  other.clearances.resize(1);
  other.n_clearances = 1;
  EXPECT_NE(DigestOf(one), DigestOf(other));
}

TEST_F(BallotTest, MoreThanHalfOfAllSettleItAtOnce) {
  Open();
  EXPECT_FALSE(three_.Close(kAsked, AllSound));
  three_.Cast("scheduler-3", Proposal(2), kAsked + 5);
  EXPECT_FALSE(three_.Close(kAsked + 5, AllSound)) << "one of three may be wrong";
  three_.Cast("scheduler-1", Proposal(2), kAsked + 6);
  const auto result = three_.Close(kAsked + 6, AllSound);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->by, "scheduler-1");
  EXPECT_EQ(result->dispute, "");
  EXPECT_EQ(three_.Late("scheduler-2", Proposal(2), kAsked + 7), "");
}

TEST_F(BallotTest, AMajorityOverrulesOneThatDiffersWhateverItWeighs) {
  Open();
  three_.Cast("scheduler-1", Proposal(9), kAsked + 5);
  three_.Cast("scheduler-2", Proposal(2), kAsked + 6);
  EXPECT_FALSE(three_.Close(kAsked + 6, AllSound));
  three_.Cast("scheduler-3", Proposal(2), kAsked + 7);
  const auto result = three_.Close(kAsked + 7, AllSound);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->by, "scheduler-2");
  EXPECT_EQ(result->proposal.schedule.n, 2);
  EXPECT_EQ(result->dispute,
            "decision 3: scheduler-2 (2 actions, weight 2) is taken by majority, against "
            "scheduler-1 (9 actions, weight 9)");
}

TEST_F(BallotTest, OneThatDiffersLaterIsToldOnce) {
  Open();
  three_.Cast("scheduler-1", Proposal(2), kAsked + 5);
  three_.Cast("scheduler-2", Proposal(2), kAsked + 6);
  ASSERT_TRUE(three_.Close(kAsked + 6, AllSound));
  EXPECT_EQ(three_.Late("scheduler-3", Proposal(9), kAsked + 7),
            "decision 3: scheduler-1 (2 actions, weight 2) was taken, scheduler-3 (9 actions, "
            "weight 9) comes later and differs");
  EXPECT_EQ(three_.Late("scheduler-3", Proposal(9), kAsked + 8), "");
  EXPECT_EQ(three_.Late("scheduler-3", Proposal(9, 2), kAsked + 8), "") << "nothing is known of it";
}

TEST_F(BallotTest, OfTwoTheCheckerDecidesThenTheWeightThenTheName) {
  const auto settle = [&](int of_1, int of_2, const Ballot::IsSound& is_sound) {
    two_.Open(kAsked);
    two_.Cast("scheduler-1", Proposal(of_1), kAsked + 5);
    two_.Cast("scheduler-2", Proposal(of_2), kAsked + 6);
    return *two_.Close(kAsked + 6, is_sound);
  };
  const auto few = [](const proposal_t& proposal) { return proposal.schedule.n < 5; };
  const auto none = [](const proposal_t&) { return false; };
  EXPECT_EQ(settle(9, 2, few).by, "scheduler-2");
  EXPECT_EQ(settle(9, 2, few).dispute,
            "decision 3: scheduler-2 (2 actions, weight 2) is taken as it alone passes the "
            "checker, against scheduler-1 (9 actions, weight 9)");
  EXPECT_EQ(settle(9, 2, AllSound).by, "scheduler-1");
  EXPECT_EQ(settle(2, 9, AllSound).by, "scheduler-2");
  EXPECT_EQ(settle(2, 9, none).by, "scheduler-2");
  // Of the same weight, and different.
  two_.Open(kAsked);
  two_.Cast("scheduler-2", Proposal(2), kAsked);
  proposal_t other = Proposal(2);
  other.schedule.candidates = 7;
  two_.Cast("scheduler-1", other, kAsked);
  EXPECT_EQ(two_.Close(kAsked, AllSound)->by, "scheduler-1");
}

TEST_F(BallotTest, OneThatIsAwayIsWaitedForOnce) {
  Open();
  two_.Cast("scheduler-2", Proposal(2), kAsked + 5);
  EXPECT_EQ(two_.due_us(), kAsked + 5 + Ballot::kGraceUs);
  EXPECT_FALSE(two_.Close(two_.due_us() - 1, AllSound));
  ASSERT_TRUE(two_.Close(two_.due_us(), AllSound));
  // The next decision is not late.
  two_.Open(2 * kAsked);
  two_.Cast("scheduler-2", Proposal(2, 4), 2 * kAsked + 5);
  ASSERT_TRUE(two_.Close(2 * kAsked + 5, AllSound));
  // It is back, if not first; so it is waited for again.
  EXPECT_EQ(two_.Late("scheduler-1", Proposal(2, 4), 2 * kAsked + 100), "");
  two_.Open(3 * kAsked);
  two_.Cast("scheduler-2", Proposal(2, 5), 3 * kAsked);
  EXPECT_FALSE(two_.Close(3 * kAsked, AllSound));
}

TEST_F(BallotTest, ASlowDecisionIsWaitedForAsLongAgain) {
  Open();
  two_.Cast("scheduler-2", Proposal(2), kAsked + kSecondUs);
  EXPECT_EQ(two_.due_us(), kAsked + 2 * kSecondUs);
  ASSERT_TRUE(two_.Close(two_.due_us(), AllSound));
  // Later than that it is not in time.
  EXPECT_EQ(two_.Late("scheduler-1", Proposal(2), two_.due_us() + 1), "");
  two_.Open(2 * kAsked);
  two_.Cast("scheduler-2", Proposal(2, 4), 2 * kAsked + 5);
  EXPECT_TRUE(two_.Close(2 * kAsked + 5, AllSound));
}

TEST_F(BallotTest, WithoutAProposalItStaysOpen) {
  Open();
  EXPECT_EQ(three_.due_us(), kNever);
  EXPECT_FALSE(three_.Close(kNever, AllSound));
  EXPECT_TRUE(three_.empty());
}

TEST_F(BallotTest, OneThatStartsAgainHasOneVote) {
  Open();
  three_.Cast("scheduler-1", Proposal(2), kAsked);
  three_.Cast("scheduler-1", Proposal(2), kAsked + 5);
  EXPECT_FALSE(three_.Close(kAsked + 5, AllSound));
  three_.Cast("scheduler-1", Proposal(9), kAsked + 6);
  three_.Cast("scheduler-2", Proposal(9), kAsked + 7);
  EXPECT_EQ(three_.Close(kAsked + 7, AllSound)->proposal.schedule.n, 9);
}

}  // namespace
}  // namespace muster::world
