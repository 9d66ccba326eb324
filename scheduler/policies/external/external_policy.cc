#include "scheduler/policies/external/external_policy.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/check.h"
#include "base/command_text.h"
#include "base/index.h"
#include "base/say.h"
#include "base/text.h"
#include "scheduler/checker.h"

namespace muster::scheduler {
namespace {

using Json = nlohmann::ordered_json;

/// A message holds no longer name of a policy.
constexpr std::size_t kLongestName = 256;
/// Lines about earlier situations, or about this one again, that are passed over.
constexpr int kMostPassedOver = 1000;

double SecondsOf(LineProgram::Clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

/// The answer as a decision; none, and why, when it breaks a rule.
std::optional<Decision> DecisionOf(const Answer& answer, const Situation& situation,
                                   const std::optional<Candidates>& candidates,
                                   std::string* problem) {
  std::vector<Action> actions = answer.actions;
  for (std::size_t i = 0; i < answer.nodes.size(); ++i) {
    const std::int64_t n = candidates ? static_cast<std::int64_t>(candidates->nodes.size()) : 0;
    if (answer.nodes[i] >= n) {
      *problem = fmt::format("nodes[{}] is {}, offered were {}", i, answer.nodes[i], n);
      return {};
    }
    actions.push_back(candidates->ToAction(situation, candidates->nodes[At(answer.nodes[i])]));
  }
  const std::vector<Violation> violations = CheckActions(situation, actions);
  if (!violations.empty()) {
    *problem = violations.front().message;
    if (violations.size() > 1) *problem += fmt::format(" (and {} more)", violations.size() - 1);
    return {};
  }
  if (!answer.by_node) {
    // A free move weighs nothing, as those of the other policies.
    const ActionWeights weights(situation);
    for (Action& action : actions) action.weight = weights.Of(action).value_or(0);
  }
  return MakeDecision(std::move(actions),
                      candidates ? static_cast<std::int64_t>(candidates->nodes.size()) : 0);
}

}  // namespace

ExternalPolicy::ExternalPolicy(std::string_view name) {
  const std::string shown = Quote(name);
  if (name.size() > kLongestName) {
    throw InputError("policy", "length", fmt::format("{} bytes", name.size()),
                     fmt::format("at most {}: put a longer command into a script", kLongestName));
  }
  bool is_text = !HasControls(name);
  try {
    [[maybe_unused]] const std::string json = Json(name).dump();
  } catch (const Json::exception&) {
    is_text = false;
  }
  const auto words = WordsOf(name.substr(kExternalPrefix.size()));
  if (!is_text || !words || words->empty()) {
    throw InputError("policy", "external", shown,
                     "external:COMMAND, UTF-8 without control characters, quotation marks closed");
  }
  argv_ = *words;
  const auto program = FindProgram(argv_.front());
  if (!program) {
    throw InputError("policy", "external", Quote(argv_.front()),
                     "a program: a path, or a name in PATH (docs/guide/external-schedulers.md)");
  }
  argv_.front() = *program;
}

bool ExternalPolicy::SetDeadline(LineProgram::Clock::duration deadline) {
  deadline_ = deadline;
  return true;
}

Decision ExternalPolicy::Decide(const Situation& situation) {
  std::string problem;
  for (int ask = 0; ask < kMostAsks; ++ask) {
    if (!program_ && failures_ >= kMostFailures) {
      problem = fmt::format("the program failed {} times in a row and is left alone", failures_);
      break;
    }
    Decision decision;
    const Reply reply = Ask(situation, &decision, &problem);
    if (reply == Reply::kAnswered) return decision;
    if (reply == Reply::kUnusable) break;
    if (ask + 1 < kMostAsks) {
      Say("external: decision {}: {}; asked again\n", situation.decision, Quote(problem));
    }
  }
  Decision stay = MakeDecision({}, 0);
  stay.refused = fmt::format("decision {}: {}", situation.decision, Quote(problem));
  Say("external: {}: everybody stays\n", stay.refused);
  return stay;
}

ExternalPolicy::Reply ExternalPolicy::Ask(const Situation& situation, Decision* decision,
                                          std::string* problem) {
  if (!program_) {
    const Reply reply = Start(problem);
    if (reply != Reply::kAnswered) return reply;
  }
  const auto asked_for = std::chrono::duration_cast<LineProgram::Clock::duration>(
      std::chrono::duration<double>(greeting_.deadline_s.value_or(SecondsOf(kDefaultDeadline))));
  const auto deadline = deadline_.value_or(asked_for);
  Json line = {{"type", "situation"}, {"id", ++asked_}, {"deadline_s", SecondsOf(deadline)}};
  line.update(ToJson(situation));
  std::optional<Candidates> candidates;
  if (greeting_.wishes.nodes) {
    candidates = EnumerateCandidates(situation);
    AddGraph(situation, *candidates, greeting_.wishes, &line);
  }
  program_->Write(line.dump());
  return AwaitAnswer(situation, candidates, deadline, decision, problem);
}

ExternalPolicy::Reply ExternalPolicy::Start(std::string* problem) {
  asked_ = 0;
  try {
    program_ = std::make_unique<LineProgram>(argv_);
  } catch (const SystemError& error) {
    ++failures_;
    *problem = error.what();
    return Reply::kEnded;
  }
  program_->Write(
      Json({{"type", "hello"}, {"protocol", "muster-scheduler"}, {"version", kExternalVersion}})
          .dump());
  std::string line;
  const auto outcome = program_->Read(LineProgram::Clock::now() + kGreetingDeadline, &line);
  if (outcome != LineProgram::Outcome::kLine) {
    return GiveUp(outcome, "greeting", kGreetingDeadline, problem);
  }
  try {
    greeting_ = ReadGreeting(line);
  } catch (const InputError& error) {
    ++failures_;
    program_.reset();
    *problem = fmt::format("no greeting: {}", error.what());
    return Reply::kUnusable;
  }
  return Reply::kAnswered;
}

ExternalPolicy::Reply ExternalPolicy::AwaitAnswer(const Situation& situation,
                                                  const std::optional<Candidates>& candidates,
                                                  LineProgram::Clock::duration deadline,
                                                  Decision* decision, std::string* problem) {
  const auto until = LineProgram::Clock::now() + deadline;
  for (int passed_over = 0; passed_over <= kMostPassedOver; ++passed_over) {
    std::string line;
    const auto outcome = program_->Read(until, &line);
    if (outcome != LineProgram::Outcome::kLine) {
      return GiveUp(outcome, "answer", deadline, problem);
    }
    Answer answer;
    try {
      answer = ReadAnswer(line, situation);
    } catch (const InputError& error) {
      *problem = error.what();
      return Reply::kUnusable;
    }
    if (answer.id < asked_) {
      if (passed_over == 0) {  // a program may repeat itself a thousand times
        Say("external: decision {}: passed over a line about situation {}, which is answered\n",
            situation.decision, answer.id);
      }
      continue;
    }
    failures_ = 0;
    if (answer.id > asked_) {
      *problem = fmt::format("an answer to situation {}, asked was {}", answer.id, asked_);
      return Reply::kUnusable;
    }
    std::optional<Decision> decided = DecisionOf(answer, situation, candidates, problem);
    if (!decided) return Reply::kUnusable;
    *decision = std::move(*decided);
    return Reply::kAnswered;
  }
  program_.reset();
  ++failures_;
  *problem = fmt::format("more than {} lines about earlier situations", kMostPassedOver);
  return Reply::kUnusable;
}

ExternalPolicy::Reply ExternalPolicy::GiveUp(LineProgram::Outcome outcome, std::string_view what,
                                             LineProgram::Clock::duration deadline,
                                             std::string* problem) {
  ++failures_;
  const std::string end = program_->Kill();
  program_.reset();
  switch (outcome) {
    case LineProgram::Outcome::kLate:
      *problem =
          fmt::format("no {} within {:g} s; the program is ended", what, SecondsOf(deadline));
      return Reply::kUnusable;
    case LineProgram::Outcome::kTooLong:
      *problem = fmt::format("no {} in {} MiB without a newline; the program is ended", what,
                             LineProgram::kMostBytes >> 20);
      return Reply::kUnusable;
    default:
      *problem = fmt::format("no {}: the program {}", what, end);
      return Reply::kEnded;
  }
}

}  // namespace muster::scheduler
