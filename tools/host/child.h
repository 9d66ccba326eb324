#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "base/spawn.h"

namespace muster::tools {

/// What to start.
struct ChildSpec {
  std::string name;               ///< for messages, e.g. "uav-1"
  std::vector<std::string> argv;  ///< argv[0] is the program's path
  std::string output_file;        ///< takes its stdout and stderr
  bool append = false;            ///< keep what output_file holds
  bool hold_stdin = false;        ///< stdin is a pipe that stays open, and tells it our end
  DiskWaits disk_waits = DiskWaits::kAsIs;
  std::string input = {};  ///< a line for its stdin, which only it reads; "": /dev/null
};

/// How a process ended.
struct ChildEnd {
  int wait_status = 0;     ///< as of waitpid(2)
  bool was_asked = false;  ///< by AskToEnd
  bool clean() const;  ///< exit code 0, or, as it was asked, by SIGTERM before it could catch it
  bool usage_error() const;  ///< exit code 2: it would end so each time
  /// "exited with code 3", "was killed by signal 9 (Killed)"
  std::string Text() const;
};

/// A process of ours. It runs in a process group of its own (a terminal's Ctrl-C reaches the parent
/// alone, which ends its children in order), reads from stdin what its spec says, inherits no other
/// open file, and is killed by the kernel when the thread that started it ends in any way.
class Child {
 public:
  /// Starts it. Throws SystemError when the program cannot be executed or the file not be written.
  explicit Child(ChildSpec spec);
  /// Kills (SIGKILL) and reaps what still runs.
  ~Child();
  Child(Child&& other) noexcept;
  Child& operator=(Child&&) = delete;

  const ChildSpec& spec() const { return spec_; }
  pid_t pid() const { return pid_; }

  /// Reaps it if it has ended; never waits. Its end, once known, stays known.
  const std::optional<ChildEnd>& Poll();
  void Signal(int signal);
  /// Continues it if a signal holds it, then sends SIGTERM. If the child's stdin is
  /// held, closes that instead: the program that the child stands for ends, and then the child.
  void AskToEnd();
  /// Whether a signal holds it now.
  bool Stopped() const;

 private:
  ChildSpec spec_;
  pid_t pid_ = -1;
  int stdin_fd_ = -1;  ///< our end, with hold_stdin
  bool was_asked_ = false;
  std::optional<ChildEnd> end_;
};

/// The last `lines` lines of a text file, without the newline at its end; "" when it cannot be
/// read.
std::string LastLines(const std::string& file, int lines);

}  // namespace muster::tools
