#pragma once

#include <vector>

#include "scheduler/nodes.h"

namespace muster::scheduler::paper::testing {

/// A graph to work out by hand: two UAVs, two workers, two tasks.
///
///   id  node     weight
///    0  U0         0.7
///    1  U0 T0 W0 100
///    2  U0 T1 W1  99.5
///    3  U1         0.7
///    4  U1 T0 W0  90
///    5  W0         0.7
///    6  W1         0.7
///    7  W0 T0      1.3   (only with_barrier)
///
/// The best independent set is {2, 4}: 189.5. Greedy takes 1, then U1 and W1 stay: 101.4. From
/// there sigma(2) = 99.5 - 100 - 0.7 and sigma(4) = 90 - 100 - 0.7 are negative: a local optimum.
struct HandGraph {
  explicit HandGraph(bool with_barrier) {
    elements.n_uavs = elements.n_workers = elements.n_tasks = 2;
    elements.capacity.assign(6, 1);
    nodes = {
        {0.7, 0, -1, -1, ActionKind::kUavStays},    {100, 0, 0, 0, ActionKind::kSense},
        {99.5, 0, 1, 1, ActionKind::kSense},        {0.7, 1, -1, -1, ActionKind::kUavStays},
        {90, 1, 0, 0, ActionKind::kSense},          {0.7, -1, 0, -1, ActionKind::kWorkerStays},
        {0.7, -1, 1, -1, ActionKind::kWorkerStays},
    };
    if (with_barrier) nodes.push_back({1.3, -1, 0, 0, ActionKind::kWorkerToTask});
  }
  Elements elements;
  std::vector<Node> nodes;
};

}  // namespace muster::scheduler::paper::testing
