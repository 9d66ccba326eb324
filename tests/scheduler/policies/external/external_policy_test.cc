#include "scheduler/policies/external/external_policy.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/check.h"
#include "scheduler/checker.h"
#include "scheduler/policies/external/situation_json.h"
#include "scheduler/policies/registry.h"
#include "tests/scheduler/situation_builder.h"
#include "tests/temporary_folder.h"

namespace muster::scheduler {
namespace {

using testing::RandomSituation;
using testing::SituationBuilder;

constexpr const char* kHello = R"({"type":"hello","version":1})";

/// Two of each class, two tasks, two charging points, all within reach.
Situation Small(std::int32_t decision = 0) {
  SituationBuilder builder;
  builder.Uav({1e3, 1e3}).Uav({2e3, 1e3}, 20e3).Worker({1e3, 2e3}).Worker({2e3, 2e3});
  builder.Vehicle({3e3, 1e3}).Vehicle({3e3, 2e3}).Task({2e3, 3e3}).Task({3e3, 3e3});
  return builder.Charge({4e3, 1e3}).Charge({4e3, 2e3}).Decision(decision).Build();
}

std::string Actions(const std::string& list, const std::string& id = "'$i'") {
  return fmt::format(R"(echo '{{"type":"decision","id":{},"actions":[{}]}}')", id, list);
}

class External : public ::testing::Test {
 protected:
  /// A program that greets and then does `body` (words of sh) for each situation, the i-th of them
  /// in $line. It is known by the file `pids`, to which each start adds its id.
  std::unique_ptr<ExternalPolicy> Program(const std::string& body,
                                          const std::string& hello = kHello) {
    std::ofstream(File("program")) << fmt::format(
        "echo $$ >>{}\nread -r line\necho '{}'\ni=0\n"
        "while read -r line; do\n  i=$((i+1))\n  {}\ndone\n",
        File("pids"), hello, body);
    auto policy = std::make_unique<ExternalPolicy>("external:sh " + File("program"));
    policy->SetDeadline(std::chrono::minutes(1));
    return policy;
  }
  std::string File(const std::string& name) const { return (folder_.path() / name).string(); }
  std::vector<pid_t> Pids() const {
    std::ifstream file(File("pids"));
    return {std::istream_iterator<pid_t>(file), {}};
  }
  /// Whether it ends within a minute; whoever is killed takes a moment.
  static bool Ends(pid_t pid) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (Runs(pid) && std::chrono::steady_clock::now() < until) std::this_thread::yield();
    return !Runs(pid);
  }
  static bool Runs(pid_t pid) {
    std::ifstream file(fmt::format("/proc/{}/stat", pid));
    std::string text;
    std::getline(file, text);
    const std::size_t state = text.rfind(") ");
    return state != std::string::npos && text[state + 2] != 'Z';
  }

  TemporaryFolder folder_;
};

TEST(ExternalNames, OfNoProgramAreRefused) {
  const std::string long_name = "external:sh " + std::string(300, 'x');
  for (const std::string& name :
       {std::string("external:"), std::string("external:no-such-program-there"),
        std::string("external:/dev/null"), std::string("external:sh 'open"),
        std::string("external:sh \x01"), std::string("external:sh \xff"), long_name}) {
    EXPECT_THROW(MakePolicy(name), InputError) << name;
  }
  EXPECT_NO_THROW(MakePolicy("external:sh -c true", 10.0));
}

TEST(ExternalSituation, SaysWhichTasksTheCommanderHasForbidden) {
  SituationBuilder builder;
  Directive forbid;
  forbid.kind = Directive::Kind::kForbid;
  forbid.agents = {-1, 1, -1};
  forbid.task = 0;
  builder.scenario().directives = {forbid};
  builder.Worker({1e3, 1e3}).Worker({2e3, 1e3}).Task({3e3, 1e3});
  const nlohmann::ordered_json situation = ToJson(builder.Build());
  EXPECT_FALSE(situation["workers"][0].contains("forbidden_tasks"));
  EXPECT_EQ(situation["workers"][1]["forbidden_tasks"], (std::vector<int>{0}));
}

TEST_F(External, ActionsGetTheirWeights) {
  const Situation situation = Small();
  const Candidates candidates = EnumerateCandidates(situation);
  const auto policy = Program(Actions(R"({"kind":"UiTxWj","uav":1,"worker":0,"task":1},)"
                                      R"({"kind":"UiCyVk","uav":0,"vehicle":1,"charge":0},)"
                                      R"({"kind":"WjTx","worker":1,"task":0},)"
                                      R"({"kind":"go","vehicle":0,"x_m":100,"y_m":2e2})"));
  const Decision decision = policy->Decide(situation);
  EXPECT_EQ(decision.refused, "");
  ASSERT_EQ(decision.actions.size(), 4u);
  EXPECT_TRUE(CheckActions(situation, decision.actions).empty());
  for (const Action& action : decision.actions) {
    if (action.kind == ActionKind::kGoTo) {
      EXPECT_EQ(action.to, (Point{100, 200}));
      EXPECT_EQ(action.weight, 0);
      continue;
    }
    const auto same = [&](const Node& node) {
      return candidates.ToAction(situation, node) == action;
    };
    EXPECT_TRUE(std::any_of(candidates.nodes.begin(), candidates.nodes.end(), same))
        << ToString(action) << " " << action.weight;
  }
}

TEST_F(External, AsManyActionsAsAgentsAreNotTooMany) {
  const auto policy = Program(
      Actions(R"({"kind":"Ui","uav":0},{"kind":"Ui","uav":1},{"kind":"Wj","worker":0},)"
              R"({"kind":"Wj","worker":1},{"kind":"Vk","vehicle":0},{"kind":"Vk","vehicle":1})"));
  const Decision decision = policy->Decide(Small());
  EXPECT_EQ(decision.refused, "");
  EXPECT_EQ(decision.actions.size(), 6u);
}

TEST_F(External, EveryNodeGetsTheWeightThatItIsOfferedWith) {
  const std::string situations = File("situations");
  const auto policy = Program("echo \"$line\" >>" + situations + "\n" + Actions(""),
                              R"({"type":"hello","version":1,"name":"x","want":["edges"]})");
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const Situation situation = RandomSituation(seed);
    const Decision decision = policy->Decide(situation);
    EXPECT_EQ(decision.refused, "");
    const Candidates candidates = EnumerateCandidates(situation);
    EXPECT_EQ(decision.candidates, static_cast<std::int64_t>(candidates.nodes.size()));
    std::ifstream file(situations);
    std::string line;
    for (std::uint64_t i = 0; i <= seed; ++i) std::getline(file, line);
    const auto told = nlohmann::json::parse(line);
    ASSERT_EQ(told["nodes"].size(), candidates.nodes.size());
    EXPECT_EQ(told["id"], seed + 1);
    EXPECT_EQ(told["tasks"].size(), situation.task_status.size());
    EXPECT_EQ(told["uavs"].size(), situation.uavs.size());
    std::set<std::pair<std::size_t, std::size_t>> edges, expected;
    for (const auto& edge : told["edges"])
      edges.emplace(edge[0].get<std::size_t>(), edge[1].get<std::size_t>());
    for (std::size_t i = 0; i < candidates.nodes.size(); ++i) {
      EXPECT_EQ(told["nodes"][i]["weight"], candidates.nodes[i].weight);
      EXPECT_EQ(told["nodes"][i]["kind"], ToString(candidates.nodes[i].kind));
      for (std::size_t j = i + 1; j < candidates.nodes.size(); ++j) {
        for (const auto& e : told["nodes"][i]["elements"]) {
          const auto& others = told["nodes"][j]["elements"];
          if (told["elements"][e.get<std::size_t>()]["admits"] == 1 &&
              std::find(others.begin(), others.end(), e) != others.end()) {
            expected.insert({i, j});
          }
        }
      }
    }
    EXPECT_EQ(edges, expected);
    EXPECT_EQ(told["edges"].size(), expected.size());
  }
}

TEST_F(External, NodesAreTakenByNumber) {
  const Situation situation = Small();
  const auto policy = Program(R"(echo '{"type":"decision","id":'$i',"nodes":[2]}')",
                              R"({"type":"hello","version":1,"want":["nodes"]})");
  const Decision decision = policy->Decide(situation);
  const Candidates candidates = EnumerateCandidates(situation);
  ASSERT_EQ(decision.actions.size(), 1u) << decision.refused;
  EXPECT_EQ(decision.actions[0], candidates.ToAction(situation, candidates.nodes[2]));
}

struct Fault {
  std::string name, body, why;
};
class RefusedAnswer : public External, public ::testing::WithParamInterface<Fault> {};

TEST_P(RefusedAnswer, IsNamedAndEverybodyStays) {
  const auto policy = Program("if [ $i = 1 ]; then\n" + GetParam().body + "\nelse\n" +
                              Actions(R"({"kind":"Ui","uav":0})") + "\nfi");
  const Decision refused = policy->Decide(Small(3));
  EXPECT_TRUE(refused.actions.empty());
  EXPECT_EQ(refused.weight, 0);
  EXPECT_NE(refused.refused.find("decision 3: "), std::string::npos) << refused.refused;
  EXPECT_NE(refused.refused.find(GetParam().why), std::string::npos) << refused.refused;
  EXPECT_LT(refused.refused.size(), 2048u) << "what an event holds";
  // The next answer counts.
  const Decision next = policy->Decide(Small(4));
  EXPECT_EQ(next.refused, "");
  EXPECT_EQ(next.actions.size(), 1u);
  EXPECT_EQ(Pids().size(), 1u) << "the program went on";
}

INSTANTIATE_TEST_SUITE_P(
    All, RefusedAnswer,
    ::testing::Values(
        Fault{"NoJson", "echo hello", "valid JSON"}, Fault{"Nothing", "echo", "valid JSON"},
        Fault{"Binary", R"(printf '\377\000\001\n')", "valid JSON"},
        Fault{"Nan", Actions(R"({"kind":"go","uav":0,"x_m":NaN,"y_m":1})"), "valid JSON"},
        Fault{"TooLargeANumber", Actions(R"({"kind":"go","uav":0,"x_m":1e999,"y_m":1})"),
              "number overflow"},
        Fault{"AKeyTwice", R"(echo '{"type":"decision","id":1,"id":1,"actions":[]}')",
              "the key twice"},
        Fault{"AnUnknownKey", Actions(R"({"kind":"Ui","uav":0,"colour":"red"})"),
              "actions[0]: found the unknown key \"colour\""},
        Fault{"NoObject", "echo '[]'", "expected an object"},
        Fault{"AnotherType", R"(echo '{"type":"hello","version":1}')", "expected \"decision\""},
        Fault{"NoId", R"(echo '{"type":"decision","actions":[]}')", "id: found no such key"},
        Fault{"AnotherDecision", Actions("", "2"), "situation 2, asked was 1"},
        Fault{"NoActions", R"(echo '{"type":"decision","id":1}')", "found none"},
        Fault{"NotAList", R"(echo '{"type":"decision","id":1,"actions":{}}')", "expected an array"},
        Fault{"NoKind", Actions(R"({"uav":0})"), "expected a kind"},
        Fault{"AnUnknownKind", Actions(R"({"kind":"UiTxWjVk","uav":0})"), "one of Ui, Wj"},
        Fault{"AFraction", Actions(R"({"kind":"Ui","uav":0.5})"), "actions[0].uav: found 0.5"},
        Fault{"ANegativeId", Actions(R"({"kind":"Ui","uav":-1})"), "actions[0].uav: found -1"},
        Fault{"AHugeId", Actions(R"({"kind":"Ui","uav":99999999999})"),
              "an integer in [0, 2147483647]"},
        Fault{"AnUnknownAgent", Actions(R"({"kind":"Ui","uav":7})"), "unknown agent: uav:7"},
        Fault{"AnUnknownTask", Actions(R"({"kind":"UiTx","uav":0,"task":2})"), "ids: task 2 of 2"},
        Fault{"AnIdTooMany", Actions(R"({"kind":"Ui","uav":0,"task":1})"), "superfluous task"},
        Fault{"AnIdTooFew", Actions(R"({"kind":"UiTxWj","uav":0,"task":1})"), "no worker given"},
        Fault{"AnAgentTwice", Actions(R"({"kind":"Ui","uav":0},{"kind":"UiTx","uav":0,"task":1})"),
              "action 1 (UiTx uav:0 task:1): agent used twice"},
        Fault{"ATaskTwice",
              Actions(R"({"kind":"WjTx","worker":0,"task":1},{"kind":"UiTx","uav":0,"task":1})"),
              "task used twice"},
        Fault{"OutOfTheArea", Actions(R"({"kind":"go","uav":0,"x_m":-5,"y_m":1})"), "destination"},
        Fault{"HalfAPlace", Actions(R"({"kind":"go","uav":0,"x_m":5})"), "found a place"},
        Fault{"NoPlace", Actions(R"({"kind":"go","uav":0})"), "found no place"},
        Fault{"APlaceTooMany", Actions(R"({"kind":"Ui","uav":0,"x_m":5,"y_m":1})"), "a place"},
        Fault{"ManyActions",
              Actions(R"({"kind":"Ui","uav":0},{"kind":"Ui","uav":0},{"kind":"Ui","uav":0},)"
                      R"({"kind":"Ui","uav":0},{"kind":"Ui","uav":0},{"kind":"Ui","uav":0},)"
                      R"({"kind":"Ui","uav":0})"),
              "at most 6"},
        Fault{"NodesThatWereNotOffered", R"(echo '{"type":"decision","id":1,"nodes":[0]}')",
              "offered were 0"}),
    [](const auto& row) { return row.param.name; });

TEST_F(External, AnAnswerInPartsIsOne) {
  const auto policy =
      Program(R"(printf '{"type":"deci'; printf 'sion","id":'$i','; printf '"actions":[]}\n')");
  for (int d = 0; d < 3; ++d) EXPECT_EQ(policy->Decide(Small(d)).refused, "");
}

TEST_F(External, AnAnswerSaidAgainIsPassedOver) {
  const auto policy = Program(Actions(R"({"kind":"Ui","uav":0})") + "\n" + Actions(""));
  for (int d = 0; d < 3; ++d) {
    const Decision decision = policy->Decide(Small(d));
    EXPECT_EQ(decision.refused, "");
    EXPECT_EQ(decision.actions.size(), 1u) << "the first one counts";
  }
}

TEST_F(External, WhoSpeaksOfEarlierSituationsOnlyIsEnded) {
  const auto policy = Program(
      "yes '"
      R"({"type":"decision","id":0,"actions":[]})"
      "' | head -n 1100");
  ::testing::internal::CaptureStderr();
  for (int d = 0; d <= ExternalPolicy::kMostFailures; ++d) {
    const std::string refused = policy->Decide(Small(d)).refused;
    const char* why = d < ExternalPolicy::kMostFailures
                          ? "more than 1000 lines about earlier situations"
                          : "left alone";
    EXPECT_NE(refused.find(why), std::string::npos) << refused;
  }
  EXPECT_EQ(Pids().size(), static_cast<std::size_t>(ExternalPolicy::kMostFailures));
  const std::string said = ::testing::internal::GetCapturedStderr();
  int lines = 0;
  for (auto at = said.find("passed over"); at != said.npos; at = said.find("passed over", at + 1)) {
    ++lines;
  }
  EXPECT_EQ(lines, ExternalPolicy::kMostFailures) << "one a decision\n" << said;
}

TEST_F(External, WhoHangsIsEndedWithAllThatItStarted) {
  const auto policy = Program(
      fmt::format("if [ $i = 1 ]; then sleep 1000 & echo $! >{}; wait; fi\n", File("sleeper")));
  policy->SetDeadline(std::chrono::milliseconds(300));
  const Decision decision = policy->Decide(Small());
  EXPECT_NE(decision.refused.find("within 0.3 s"), std::string::npos) << decision.refused;
  ASSERT_EQ(Pids().size(), 1u) << "not asked again";
  EXPECT_TRUE(Ends(Pids()[0]));
  pid_t sleeper = 0;
  if (std::ifstream(File("sleeper")) >> sleeper) {
    EXPECT_TRUE(Ends(sleeper));
  }
}

TEST_F(External, WhoDoesNotReadIsEnded) {
  SituationBuilder builder;
  for (int x = 0; x < 3000; ++x) builder.Task({1e3 + x, 1e3});  // more than a pipe holds
  std::ofstream(File("program")) << "read -r line\necho '" << kHello << "'\nexec sleep 1000\n";
  ExternalPolicy policy("external:sh " + File("program"));
  policy.SetDeadline(std::chrono::milliseconds(200));
  EXPECT_NE(policy.Decide(builder.Build()).refused.find("within 0.2 s"), std::string::npos);
}

TEST_F(External, OutputWithoutEndIsCut) {
  const auto policy = Program("head -c 100000000 /dev/zero");
  const Decision decision = policy->Decide(Small());
  EXPECT_NE(decision.refused.find("in 16 MiB"), std::string::npos) << decision.refused;
}

TEST_F(External, WhoNeverStopsWritingIsLateAllTheSame) {
  // A byte now and then: never silent, never whole, never much.
  const auto policy = Program("while :; do printf x; done");
  policy->SetDeadline(std::chrono::milliseconds(50));
  const Decision decision = policy->Decide(Small());
  EXPECT_NE(decision.refused.find("within 0.05 s"), std::string::npos) << decision.refused;
}

TEST_F(External, WhoDiesIsStartedAgainAndAskedAgain) {
  const std::string died = File("died");
  const auto policy =
      Program(fmt::format("if [ ! -e {} ]; then : >{}; kill -9 $$; fi\n", died, died) +
              Actions(R"({"kind":"Ui","uav":0})"));
  const Decision decision = policy->Decide(Small());
  EXPECT_EQ(decision.refused, "");
  EXPECT_EQ(decision.actions.size(), 1u);
  EXPECT_EQ(Pids().size(), 2u);
}

TEST_F(External, WhoIsKilledBetweenDecisionsIsStartedAgain) {
  const auto policy = Program(Actions(R"({"kind":"Ui","uav":0})"));
  EXPECT_EQ(policy->Decide(Small(0)).refused, "");
  ASSERT_EQ(Pids().size(), 1u);
  ASSERT_EQ(kill(Pids()[0], SIGKILL), 0);
  EXPECT_EQ(policy->Decide(Small(1)).refused, "");
  EXPECT_EQ(Pids().size(), 2u);
}

TEST_F(External, WhoAlwaysDiesIsLeftAlone) {
  const auto policy = Program("exit 3");
  for (int d = 0; d < 4; ++d) {
    const std::string refused = policy->Decide(Small(d)).refused;
    const char* why = d < 2 ? "exited with code 3" : "left alone";
    EXPECT_NE(refused.find(why), std::string::npos) << refused;
  }
  EXPECT_EQ(Pids().size(), static_cast<std::size_t>(ExternalPolicy::kMostFailures));
}

TEST_F(External, AGreetingThatIsNoneIsRefused) {
  const std::pair<const char*, const char*> greetings[] = {
      {R"({"type":"hello","version":2})", "version: found 2, expected 1"},
      {R"({"type":"hello","version":"1"})", "version"},
      {R"({"type":"hello"})", "version: found no such key"},
      {R"({"type":"decision"})", "expected \"hello\""},
      {R"({"type":"hello","version":1,"want":["all"]})", "want: found \"all\""},
      {R"({"type":"hello","version":1,"deadline_s":0})", "deadline_s: found 0"},
      {R"({"type":"hello","version":1,"deadline_s":601})", "deadline_s"},
      {R"({"type":"hello","version":1,"depth":3})", "depth"},
      {"usage: program FILE", "valid JSON"},
  };
  for (const auto& [hello, why] : greetings) {
    const std::string refused = Program("", hello)->Decide(Small()).refused;
    EXPECT_NE(refused.find(why), std::string::npos) << refused;
    EXPECT_NE(refused.find("no greeting"), std::string::npos) << refused;
  }
}

TEST_F(External, ItInheritsNoFile) {
  const int extra = dup(STDERR_FILENO);  // one that exec would leave open
  ASSERT_GT(extra, STDERR_FILENO);
  const auto policy = Program(fmt::format("ls /proc/$$/fd >{}\n", File("files")) + Actions(""));
  EXPECT_EQ(policy->Decide(Small()).refused, "");
  close(extra);
  std::ifstream file(File("files"));
  std::set<int> files{std::istream_iterator<int>(file), {}};
  files.erase(files.lower_bound(10), files.end());  // what sh keeps of its own
  EXPECT_EQ(files, (std::set<int>{0, 1, 2})) << "not " << extra;
}

TEST_F(External, ItEndsWithUsEvenIfWeAreKilled) {
  const pid_t ours = fork();
  ASSERT_GE(ours, 0);
  if (ours == 0) {
    // It does not look at its stdin any more.
    const auto policy = Program(Actions("") + "; exec sleep 1000");
    policy->Decide(Small());
    raise(SIGKILL);
  }
  ASSERT_EQ(waitpid(ours, nullptr, 0), ours);
  ASSERT_EQ(Pids().size(), 1u);
  EXPECT_TRUE(Ends(Pids()[0]));
}

}  // namespace
}  // namespace muster::scheduler
