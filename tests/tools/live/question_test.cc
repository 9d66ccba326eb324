#include "tools/live/question.h"

#include <gtest/gtest.h>

#include "tests/tools/launch/process_test_util.h"

namespace muster::tools {
namespace {

TEST(Question, OnlyNamesOfTasksAndAgentsAreAskedAbout) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(WhyCommand("run", "task:17"), (Words{"explain", "run", "--task", "17"}));
  EXPECT_EQ(WhyCommand("run", "vehicle:3"), (Words{"explain", "run", "--agent", "vehicle:3"}));
  for (const char* name : {"", "task", "task:", "task:-1", "task:1x", "task:1:2", "charge:1",
                           "--help", "task:99999999999", "../uav:1"}) {
    EXPECT_FALSE(WhyCommand("run", name)) << name;
  }
}

/// The program that a question starts is this one.
TEST(Question, IsAnsweredByAProgramOfItsOwn) {
  Question question({"--gtest_list_tests"}, "");
  std::optional<Question::Answer> answer;
  ASSERT_TRUE(Eventually([&] { return (answer = question.Poll()).has_value(); }));
  EXPECT_TRUE(answer->good);
  EXPECT_NE(answer->text.find("IsAnsweredByAProgramOfItsOwn"), std::string::npos);
}

}  // namespace
}  // namespace muster::tools
