#pragma once

namespace muster::tools {

/// `muster task`: adds, changes, cancels, holds or resumes a task of a running mission.
int TaskCommand(int argc, const char* const* argv);
/// `muster agent`: has an agent join or leave a running mission.
int AgentCommand(int argc, const char* const* argv);
/// `muster road`: closes or opens roads of a running mission.
int RoadCommand(int argc, const char* const* argv);
/// `muster zone`: adds or lifts a zone of a running mission that UAVs keep out of.
int ZoneCommand(int argc, const char* const* argv);
/// `muster decide`: has the scheduler of a running mission decide between intervals.
int DecideCommand(int argc, const char* const* argv);

/// `muster direct`: decides in the policy's place: who does a task, who must not, who charges, who
/// goes where.
int DirectCommand(int argc, const char* const* argv);

}  // namespace muster::tools
