#pragma once

#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>
#include <vector>

#include "scheduler/situation.h"
#include "scheduler/solver/candidates.h"

namespace muster::tools {

/// One decision's conflict graph written out, for other solvers. Nodes are numbered in the order of
/// scheduler::EnumerateCandidates, from 0.
class ConflictGraph {
 public:
  explicit ConflictGraph(scheduler::Situation situation);

  std::int32_t n_nodes() const { return static_cast<std::int32_t>(nodes().size()); }
  const std::vector<scheduler::Node>& nodes() const { return candidates_.nodes; }

  /// METIS graph with node weights (header `n m 10`), as solvers of the maximum weight independent
  /// set read it: the i-th line after the header holds node i - 1's weight, times `scale` and
  /// rounded, and its neighbours counted from 1. Throws InputError when a charging point has
  /// several free places, but not unlimited ones: that is no graph.
  void WriteMetis(std::ostream& out, double scale) const;

  /// The same as a packing problem in free MPS: column nI is node I, a row per element. To be
  /// minimised, with negative weights, as solvers differ on how they are told to maximise.
  void WriteMps(std::ostream& out) const;

  /// Nodes with kind, ids, weight and elements, and what each element admits.
  void WriteJson(std::ostream& out) const;

  struct Verdict {
    double weight = 0;                   ///< of the chosen nodes, unscaled
    std::vector<std::string> conflicts;  ///< empty: independent
  };
  Verdict Check(std::span<const std::int32_t> chosen) const;

 private:
  void Neighbours(std::int32_t node, std::vector<std::int32_t>* neighbours) const;

  scheduler::Situation situation_;
  scheduler::Candidates candidates_;
  std::vector<std::vector<std::int32_t>> at_element_;  ///< nodes of each element
  mutable std::vector<std::int32_t> mark_;
};

/// What a solver's answer lists as chosen, in one of these forms:
///   indicator  one line a node, 0 or 1 (as solvers of METIS graphs write)
///   nodes      node numbers counted from 0, separated by white space
///   nodes-from-1  the same counted from 1, as in the METIS file (CHILS writes them so)
///   mps        lines that hold a column's name nI and then its value, as MILP solvers write
/// Throws InputError naming `file` and what is wrong in it.
std::vector<std::int32_t> ReadSolution(std::istream& in, const std::string& file,
                                       const std::string& form, std::int32_t n_nodes);

}  // namespace muster::tools
