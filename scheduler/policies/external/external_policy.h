#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/line_program.h"
#include "scheduler/policies/external/answer.h"
#include "scheduler/policy.h"

namespace muster::scheduler {

/// A policy of that name is a program of the user's: the rest of the name is its command.
inline constexpr std::string_view kExternalPrefix = "external:";

/// A program that decides, as docs/guide/external-schedulers.md has it. An answer that is late,
/// cannot be read or breaks a rule is refused: everybody stays, and Decision::refused says why. A
/// program that ends is started again and asked again, one that hangs is ended and started again
/// for the next decision; one that has failed kMostFailures times in a row is left alone from then
/// on.
class ExternalPolicy : public Policy {
 public:
  /// `name` with the prefix. Throws InputError when there is no such program, or when the name is
  /// longer than a message's can be. The program is started at the first decision.
  explicit ExternalPolicy(std::string_view name);

  Decision Decide(const Situation& situation) override;
  /// For each decision; goes before what the program asks for.
  bool SetDeadline(LineProgram::Clock::duration deadline) override;

  static constexpr std::chrono::seconds kDefaultDeadline{3};
  /// For the program to start and greet.
  static constexpr std::chrono::seconds kGreetingDeadline{10};
  /// How often it is asked about one situation, when it ends over it.
  static constexpr int kMostAsks = 3;
  static constexpr int kMostFailures = 6;

 private:
  enum class Reply { kAnswered, kEnded, kUnusable };

  /// Everything below puts into `problem` what went wrong.
  Reply Ask(const Situation& situation, Decision* decision, std::string* problem);
  Reply Start(std::string* problem);
  Reply AwaitAnswer(const Situation& situation, const std::optional<Candidates>& candidates,
                    LineProgram::Clock::duration deadline, Decision* decision,
                    std::string* problem);
  /// The program is of no use any more.
  Reply GiveUp(LineProgram::Outcome outcome, std::string_view what,
               LineProgram::Clock::duration deadline, std::string* problem);

  std::vector<std::string> argv_;
  std::optional<LineProgram::Clock::duration> deadline_;
  std::unique_ptr<LineProgram> program_;  ///< while it runs, and has greeted
  Greeting greeting_;
  std::int64_t asked_ = 0;  ///< id of the newest situation
  int failures_ = 0;        ///< in a row, of the program itself
};

}  // namespace muster::scheduler
