#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "scheduler/nodes.h"

namespace muster::tools {

/// COIN-OR CBC, to compare with. Loaded when the program runs (libCbcSolver.so.3 of Debian's
/// coinor-libcbc3), so nothing links it and nothing has to be installed.
class GeneralSolver {
 public:
  /// Null where it is not installed.
  static std::unique_ptr<GeneralSolver> Load();
  virtual ~GeneralSolver() = default;

  struct Answer {
    std::optional<double> weight;  ///< none: not proven within the time
    double cpu_s = 0;              ///< of the process, the problem's set-up not counted
  };
  /// The heaviest packing of the nodes; with `shares`, which may then take part of a node, its
  /// linear relaxation.
  virtual Answer Heaviest(const std::vector<scheduler::Node>& nodes,
                          const scheduler::Elements& elements, bool shares, double seconds) = 0;
};

/// Processor time of this process, seconds.
double CpuSeconds();

}  // namespace muster::tools
