#include "tools/graph/graph_commands.h"

#include <fmt/format.h>

#include <cerrno>
#include <fstream>
#include <string>

#include "base/check.h"
#include "base/program.h"
#include "scheduler/policies/certified/certified_policy.h"
#include "scheduler/policies/registry.h"
#include "tools/files/pending_file.h"
#include "tools/graph/conflict_graph.h"
#include "tools/graph/situations.h"

namespace muster::tools {
namespace {

void AddDecisionOptions(cxxopts::Options* options) {
  options->add_options()("mission", "Run directory, log file, or scenario file (.json)",
                         cxxopts::value<std::string>(), "RUN_OR_SCENARIO")(
      "decision", "Number of the decision, from 0", cxxopts::value<int>()->default_value("0"), "D")(
      "policy", "How the decisions before it are made, for a scenario",
      cxxopts::value<std::string>()->default_value(std::string(scheduler::kDefaultPolicy)), "NAME");
  options->parse_positional({"mission"});
  options->positional_help("RUN_OR_SCENARIO");
}

scheduler::Situation ReadSituation(const cxxopts::ParseResult& flags) {
  if (flags.count("mission") == 0) {
    throw InputError("options", "RUN_OR_SCENARIO", "nothing",
                     "a run directory, a log file or a scenario file");
  }
  return SituationOf(flags["mission"].as<std::string>(), flags["policy"].as<std::string>(),
                     flags["decision"].as<int>());
}

}  // namespace

int ExportGraphCommand(int argc, const char* const* argv) {
  cxxopts::Options options("muster export-graph",
                           "Writes the conflict graph of one decision for other solvers.");
  AddDecisionOptions(&options);
  options.add_options()("format", "metis, mps or json",
                        cxxopts::value<std::string>()->default_value("metis"),
                        "FORMAT")("scale", "METIS: weights are multiplied by this and rounded",
                                  cxxopts::value<double>()->default_value("1000000"), "S")(
      "out", "File to write", cxxopts::value<std::string>(), "FILE");
  const auto flags = ParseOptions(&options, argc, argv);
  if (!flags) return kExitOk;
  const auto format = (*flags)["format"].as<std::string>();
  const auto scale = (*flags)["scale"].as<double>();
  if (format != "metis" && format != "mps" && format != "json") {
    throw InputError("options", "--format", format, "metis, mps or json");
  }
  // The heaviest node weighs about 103, and solvers add weights up in 64 bits or in 32.
  if (!(scale >= 1 && scale <= 1e12)) {
    throw InputError("options", "--scale", fmt::to_string(scale), "a number from 1 to 1e12");
  }
  if (flags->count("out") == 0) throw InputError("options", "--out", "nothing", "a file to write");
  const auto out_file = (*flags)["out"].as<std::string>();

  const scheduler::Situation situation = ReadSituation(*flags);
  const ConflictGraph graph(situation);
  PendingFile pending(out_file);
  std::ofstream out(pending.temporary());
  if (!out) FailToWrite(out_file, errno);
  if (format == "metis") graph.WriteMetis(out, scale);
  if (format == "mps") graph.WriteMps(out);
  if (format == "json") graph.WriteJson(out);
  out.close();
  if (!out) FailToWrite(out_file, errno);
  pending.Commit();
  fmt::print("{}: decision {}, {} nodes\n", out_file, situation.decision, graph.n_nodes());
  return kExitOk;
}

int CheckSolutionCommand(int argc, const char* const* argv) {
  cxxopts::Options options("muster check-solution",
                           "Verifies another solver's answer on an exported conflict graph.");
  AddDecisionOptions(&options);
  options.add_options()("solution", "The solver's answer", cxxopts::value<std::string>(), "FILE")(
      "form",
      "indicator (a line of 0 or 1 a node), nodes (numbers from 0) or mps (lines 'nI value')",
      cxxopts::value<std::string>()->default_value("indicator"), "FORM");
  const auto flags = ParseOptions(&options, argc, argv);
  if (!flags) return kExitOk;
  if (flags->count("solution") == 0) {
    throw InputError("options", "--solution", "nothing", "a file with the solver's answer");
  }
  const auto file = (*flags)["solution"].as<std::string>();
  std::ifstream in(file);
  if (!in) throw SystemError(fmt::format("{}: cannot be read", file));

  const scheduler::Situation situation = ReadSituation(*flags);
  const ConflictGraph graph(situation);
  const auto chosen = ReadSolution(in, file, (*flags)["form"].as<std::string>(), graph.n_nodes());
  const ConflictGraph::Verdict verdict = graph.Check(chosen);
  for (const std::string& conflict : verdict.conflicts) fmt::print("conflict: {}\n", conflict);
  const scheduler::Decision ours = scheduler::DecideCertified(situation, {}, nullptr);
  fmt::print("decision {}: {} of {} nodes, weight {:.6f}; ours {:.6f}, proven bound {:.6f}\n",
             situation.decision, chosen.size(), graph.n_nodes(), verdict.weight, ours.weight,
             ours.bound);
  if (!verdict.conflicts.empty()) {
    fmt::print("not independent: {} conflicts\n", verdict.conflicts.size());
    return kExitCheckFailed;
  }
  fmt::print("independent, {:.6f} % below the bound\n",
             ours.bound > 0 ? 100 * (ours.bound - verdict.weight) / ours.bound : 0.0);
  return kExitOk;
}

}  // namespace muster::tools
