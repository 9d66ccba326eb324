#include "tools/audit/audit_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/text_file.h"
#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/bus/member_keys.h"
#include "tools/audit/auditor.h"
#include "tools/audit/report_check.h"
#include "tools/audit/seal_proof.h"
#include "tools/files/log_files.h"
#include "tools/files/log_progress.h"

namespace muster::tools {
namespace {

using audit::Violation;

constexpr std::size_t kListed = 20;

std::string Clock(std::int64_t us) {
  const std::int64_t s = us / 1'000'000;
  return fmt::format("{:02}:{:02}:{:02}.{:06}", s / 3600, s / 60 % 60, s % 60, us % 1'000'000);
}

void CompareReport(const std::string& file, const audit::Facts& facts,
                   std::vector<Violation>* violations) {
  const auto report = nlohmann::json::parse(ReadTextFile(file, "a report"), nullptr, false);
  if (report.is_discarded() || !report.is_object()) {
    throw InputError(fmt::format("{}: not a JSON object", file));
  }
  const std::vector<Violation> found = audit::CheckReportFile(report, facts);
  violations->insert(violations->end(), found.begin(), found.end());
}

nlohmann::ordered_json ToJson(const audit::Auditor& auditor,
                              const std::vector<Violation>& violations, bool report_checked,
                              std::int64_t garbage_bytes,
                              const std::optional<audit::SealProof>& proof) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Violation& v : violations) {
    list.push_back({{"at_us", v.at_us}, {"invariant", v.invariant}, {"text", v.text}});
  }
  return {
      {"passed", violations.empty()},
      {"holds_so_far", violations.empty() || (auditor.holds_so_far() && violations.size() == 2)},
      {"messages", auditor.messages()},
      {"duplicates", auditor.duplicates()},
      {"undecodable", auditor.undecodable()},
      {"garbage_bytes", garbage_bytes},
      {"proven", proof ? proof->proven() : 0},
      {"refused", proof ? proof->refused() : 0},
      {"ticks", auditor.ticks()},
      {"decisions", auditor.decisions()},
      {"activities", auditor.activities()},
      {"report_checked", report_checked},
      {"violations", std::move(list)}};
}

void PrintSeparation(const audit::Auditor& auditor) {
  const audit::View::Closest* const closest = auditor.closest();
  if (closest == nullptr) return;
  fmt::print("UAVs are kept apart: {}",
             std::isinf(closest->share)
                 ? "no two come near each other"
                 : fmt::format("the closest come within {:.0f} m across and {:.0f} m up",
                               closest->across_m, closest->above_m));
  if (closest->leftover > 0) {
    fmt::print("; pairs too close by what no decision planned: {}", closest->leftover);
  }
  fmt::print("\n");
}

void PrintViolations(const audit::Auditor& auditor, const std::vector<Violation>& violations) {
  if (auditor.holds_so_far() && violations.size() == 2) {
    fmt::print(
        "every rule holds up to {}, where the log ends. The mission ends at {}: it still runs, "
        "or was broken off\n",
        Clock(violations.front().at_us), Clock(auditor.limit_us()));
    return;
  }
  fmt::print("FAILED, {} violations, the first ones:\n", violations.size());
  for (std::size_t i = 0; i < std::min(kListed, violations.size()); ++i) {
    const Violation& v = violations[i];
    fmt::print("  {}  {}: {}\n", Clock(v.at_us), v.invariant, v.text);
  }
}

/// By a key, or by a file like seal.public. Throws InputError where the senders that seal.public
/// names have other keys than those which the key makes.
audit::SealProof ProofBy(const std::string& file, const std::string& log) {
  const std::string text = ReadTextFile(file, "a key");
  if (text.starts_with('{')) return {Seal(MemberKeys::Parse(text, file)), file};
  const SealKey key = SealKey::Load(file);
  const std::optional<Seal> beside = SealBeside(log);
  if (!beside || beside->members() == nullptr) return {key, file};
  const MemberKeys& members = *beside->members();
  if (!members.AreOf(key.Of(members.run_id(), file).bytes)) {
    throw InputError(std::string(kSealPublicFile), "members", "keys that are not of this mission",
                     fmt::format("those that {} makes", file));
  }
  return {*beside, file};
}

}  // namespace

int AuditCommand(int argc, const char* const* argv) {
  Options options(argv[0],
                  "Checks a run's log against every rule of the mission, and report.json against "
                  "the log.\nExit code 4 when one is broken.");
  options.Run();
  options.Add(
      "key", "FILE",
      "The key of a sealed mission, or its seal.public: each message must have the right tag "
      "(default: what is beside the log; messages without the right tag are left out)");
  options.Json();
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const std::string run = arguments->Get("run");

  audit::Auditor auditor;
  std::int64_t garbage_bytes = 0;
  const std::vector<std::string> files = LogFilesOf(run);
  std::optional<audit::SealProof> proof;
  if (arguments->Has("key")) {
    proof.emplace(ProofBy(arguments->Get("key"), files.front()));
  } else if (auto seal = SealBeside(files.front())) {
    proof.emplace(*std::move(seal), std::string(kSealKeyFile));
  }
  LogProgress progress("audit", files);
  for (const std::string& file : files) {
    EventLogReader reader(file, EventLogReader::Tail::kFinal);
    while (const auto event = reader.Next()) {
      progress.Add(*event);
      if (!proof || proof->Takes(*event, file)) auditor.Add(event->packet);
    }
    garbage_bytes += reader.garbage_bytes();
  }
  progress.Break();
  std::vector<Violation> violations = auditor.Finish();
  if (arguments->Has("key") && proof->refused() > 0) {
    violations.insert(violations.begin(), {proof->first_refused_us(), "seal",
                                           fmt::format("{}; {} such in all", proof->first_refused(),
                                                       proof->refused())});
  }
  const std::string report = (std::filesystem::path(run) / "report.json").string();
  const bool has_report = std::filesystem::is_regular_file(report);
  if (has_report && auditor.facts()) CompareReport(report, *auditor.facts(), &violations);
  std::stable_sort(violations.begin(), violations.end(),
                   [](const Violation& a, const Violation& b) { return a.at_us < b.at_us; });

  if (arguments->Has("json")) {
    fmt::print("{}\n", ToJson(auditor, violations, has_report && auditor.facts().has_value(),
                              garbage_bytes, proof)
                           .dump(2));
    return violations.empty() ? kExitOk : kExitCheckFailed;
  }
  fmt::print("{}: {} messages, {} ticks, {} decisions, {} activities\n", run, auditor.messages(),
             auditor.ticks(), auditor.decisions(), auditor.activities());
  if (garbage_bytes > 0 || auditor.undecodable() > 0) {
    fmt::print("{} bytes and {} packets could not be read\n", garbage_bytes, auditor.undecodable());
  }
  if (proof) {
    fmt::print("sealed: {} messages have the right tag\n", proof->proven());
    if (proof->refused() > 0) {
      fmt::print("{} without it left out, the first: {}\n", proof->refused(),
                 proof->first_refused());
    }
  }
  PrintSeparation(auditor);
  if (violations.empty()) {
    fmt::print("passed: every rule holds{}\n", has_report
                                                   ? ", and report.json says what the log shows"
                                                   : "; there is no report.json to compare");
    return kExitOk;
  }
  PrintViolations(auditor, violations);
  return kExitCheckFailed;
}

}  // namespace muster::tools
