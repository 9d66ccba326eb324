#pragma once

#include <csignal>

namespace muster::tools {

/// While one exists, SIGINT, SIGTERM and SIGHUP are counted instead of ending the process, and
/// SIGCHLD interrupts a wait. What was ignored before stays so, as nohup(1) and shells want it. At
/// most one at a time; the destructor restores what was before.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  int count() const;

 private:
  struct sigaction before_[4];
};

}  // namespace muster::tools
