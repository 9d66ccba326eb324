#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace muster::tools {

/// A program on a pseudo-terminal of its own: what a user sees and presses.
class Terminal {
 public:
  /// argv[0] is the program's path.
  explicit Terminal(const std::vector<std::string>& argv);
  /// Kills what still runs.
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  void Press(const std::string& bytes);
  /// Takes what has been shown since; waits at most 10 ms for something.
  void Look();
  /// Everything shown so far.
  const std::string& shown() const { return shown_; }
  /// The last whole status line of `muster replay`; "" before the first.
  std::string status() const;
  /// Whether the terminal hands over single bytes, without echo.
  bool raw() const;
  /// The program's exit code once it has ended; -1 when a signal ended it.
  std::optional<int> ended();

 private:
  int fd_ = -1;
  pid_t pid_ = -1;
  std::optional<int> ended_;
  std::string shown_;
};

}  // namespace muster::tools
