#include "tools/graph/graph_commands.h"

#include <fmt/format.h>

#include <cerrno>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "base/check.h"
#include "base/options.h"
#include "base/program.h"
#include "base/text_file.h"
#include "scheduler/policies/certified/certified_policy.h"
#include "scheduler/policies/registry.h"
#include "tools/files/pending_file.h"
#include "tools/graph/conflict_graph.h"
#include "tools/graph/situations.h"

namespace muster::tools {
namespace {

void AddDecisionOptions(Options* options) {
  options->Positional("mission", "RUN_OR_SCENARIO")
      .Required("a run directory, a log file or a scenario file (.json)");
  options->Add("decision", "D", "Number of the decision, from 0")
      .Integer(0, std::numeric_limits<int>::max())
      .Default(0);
  scheduler::AddPolicyOption(options, "How the decisions before it are made, for a scenario:");
}

scheduler::Situation ReadSituation(const Arguments& arguments) {
  return SituationOf(arguments.Get("mission"), scheduler::PolicyFrom(arguments),
                     arguments.Get<int>("decision"));
}

}  // namespace

int ExportGraphCommand(int argc, const char* const* argv) {
  Options options("muster export-graph",
                  "Writes the conflict graph of one decision for other solvers.");
  AddDecisionOptions(&options);
  options.Add("format", "FORMAT", "metis, mps or json")
      .OneOf({"metis", "mps", "json"})
      .Default("metis");
  // The heaviest node weighs about 103, and solvers add weights up in 64 bits or in 32.
  options.Add("scale", "S", "METIS: weights are multiplied by this and rounded")
      .Number({1, 1e12})
      .Default("1000000");
  options.Out("FILE", "File to write").Required("a file to write");
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const auto format = arguments->Get("format");
  const auto out_file = arguments->Get("out");

  const scheduler::Situation situation = ReadSituation(*arguments);
  const ConflictGraph graph(situation);
  PendingFile pending(out_file);
  std::ofstream out(pending.temporary());
  if (!out) FailToWrite(out_file, errno);
  if (format == "metis") graph.WriteMetis(out, arguments->Get<double>("scale"));
  if (format == "mps") graph.WriteMps(out);
  if (format == "json") graph.WriteJson(out);
  out.close();
  if (!out) FailToWrite(out_file, errno);
  pending.Commit();
  fmt::print("{}: decision {}, {} nodes\n", out_file, situation.decision, graph.n_nodes());
  return kExitOk;
}

int CheckSolutionCommand(int argc, const char* const* argv) {
  Options options("muster check-solution",
                  "Verifies another solver's answer on an exported conflict graph.");
  AddDecisionOptions(&options);
  options.Add("solution", "FILE", "The solver's answer")
      .Required("a file with the solver's answer");
  options
      .Add("form", "FORM",
           "indicator (a line of 0 or 1 a node), nodes (numbers from 0), nodes-from-1 (as CHILS "
           "writes them) or mps (lines 'nI value')")
      .OneOf({"indicator", "nodes", "nodes-from-1", "mps"})
      .Default("indicator");
  const auto arguments = options.Parse(argc, argv);
  if (!arguments) return kExitOk;
  const auto file = arguments->Get("solution");
  std::istringstream in(ReadTextFile(file, "a solution"));

  const scheduler::Situation situation = ReadSituation(*arguments);
  const ConflictGraph graph(situation);
  const auto chosen = ReadSolution(in, file, arguments->Get("form"), graph.n_nodes());
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
