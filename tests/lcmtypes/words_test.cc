#include "lcmtypes/words.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>
#include <string>

namespace muster {
namespace {

/// Calls visit(word, where): the field that holds it, as docs/reference/wire.md says.
template <class Visit>
void ForEachWord(Visit visit) {
  visit(AgentKind::kVehicle,
        "`agent_states_t.kind`, `agent_changes_t.kind`, `ruling_t.agent_kind`");
  visit(AgentStatus::kNotReady, "`agent_t.status`");
  visit(ActionKind::kGoTo, "`action_t.kind`, `agent_t.action` (-1: none)");
  visit(ActivityKind::kCharging, "`activity_t.kind`");
  visit(TaskStatus::kHeld, "`world_state_t.task_status`");
  visit(RulingKind::kLost, "`ruling_t.kind`");
  visit(ClockPhase::kEnded, "`clock_t.phase`");
  visit(EventKind::kDriverCalls, "`event_t.kind`");
  visit(FaultKind::kZoneUnknown, "`fault_t.kind`");
  visit(ProcessState::kDeciding, "`process_status_t.state`");
}

TEST(Words, EveryNumberHasANameOfItsOwnAndBack) {
  ForEachWord([](auto last, const std::string& where) {
    using Word = decltype(last);
    ASSERT_EQ(kNames<Word>.size(), static_cast<std::size_t>(NumberOf(last)) + 1) << where;
    std::set<std::string_view> names;
    for (std::int8_t number = 0; number <= NumberOf(last); ++number) {
      const auto name = ToString<Word>(number);
      EXPECT_TRUE(IsWord<Word>(number));
      EXPECT_TRUE(!name.empty() && name != "unknown" && names.insert(name).second)
          << where << " " << int{number};
      EXPECT_EQ(ToString(static_cast<Word>(number)), name);
      EXPECT_EQ(FromString<Word>(name), static_cast<Word>(number));
    }
    EXPECT_FALSE(IsWord<Word>(NumberOf(last) + 1)) << where;
    EXPECT_FALSE(IsWord<Word>(-1)) << where;
    EXPECT_EQ(ToString<Word>(NumberOf(last) + 1), "unknown");
    EXPECT_EQ(FromString<Word>("unknown"), std::nullopt);
  });
  EXPECT_EQ(ToString(ActionKind::kNone), "none");
}

TEST(Words, AFieldIsComparedAsItStands) {
  const std::int8_t kind = 11;
  EXPECT_TRUE(kind == EventKind::kProcessLost);
  EXPECT_TRUE(kind != EventKind::kProcessBack);
  EXPECT_FALSE(std::size_t{267} == EventKind::kProcessLost);  // 11 in eight bits
}

TEST(Words, OutcomesAreToldApart) {
  std::set<std::string_view> others;
  for (std::size_t i = 0; i < kNames<EventKind>.size(); ++i) {
    if (!IsOutcome(static_cast<EventKind>(i))) others.insert(kNames<EventKind>[i]);
  }
  EXPECT_EQ(others,
            (std::set<std::string_view>{
                "process_lost", "process_back", "fault_applied", "fault_ended", "answer_refused",
                "driver_failed", "state_unknown", "directive_unkept", "action_withheld",
                "decisions_differ", "driver_waits", "driver_says", "driver_calls"}));
}

TEST(WireDocument, HasEveryWord) {
  std::ifstream file(MUSTER_WIRE_DOCUMENT);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  ASSERT_FALSE(text.empty()) << MUSTER_WIRE_DOCUMENT;
  ForEachWord([&](auto last, const std::string& where) {
    std::string row = "| " + where + " | ";
    for (std::size_t i = 0; i < kNames<decltype(last)>.size(); ++i) {
      row += fmt::format("{}{} `{}`", i == 0 ? "" : ", ", i, kNames<decltype(last)>[i]);
    }
    EXPECT_NE(text.find(row + " |\n"), std::string::npos) << row;
  });
  for (const std::string_view name :
       {process_name::kWorld, process_name::kScheduler, process_name::kRecorder,
        process_name::kLauncher, process_name::kLogger}) {
    EXPECT_NE(text.find(fmt::format("`{}`", name)), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace muster
