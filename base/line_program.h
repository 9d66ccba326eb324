#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/spawn.h"

namespace muster {

/// A child process that is spoken to in lines: one goes to its stdin, one comes from its stdout.
/// Its stderr is ours; it inherits no other open file and ends with us, however we end. Neither a
/// program that does not read nor one that writes without end holds us beyond a deadline.
class LineProgram {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Outcome {
    kLine,     ///< a whole line came
    kLate,     ///< none came in time
    kTooLong,  ///< more than most_bytes came without a newline
    kEnded,    ///< it closed its stdout, which is mostly its end
  };
  static constexpr std::size_t kMostBytes = 16 << 20;

  /// Starts argv[0], a path. Throws SystemError when it cannot be executed. `most_bytes`: a line's.
  explicit LineProgram(std::vector<std::string> argv, std::size_t most_bytes = kMostBytes);
  /// Closes its stdin, gives it a moment to end of itself, then kills it with all that it started
  /// in its process group.
  ~LineProgram();
  LineProgram(const LineProgram&) = delete;
  LineProgram& operator=(const LineProgram&) = delete;

  /// Closes its stdin: the moment that it has to end of itself begins, that of the destructor.
  void Finish();
  /// Adds a line to what it is to be told; Read writes it.
  void Write(std::string_view line);
  /// The next line of its stdout, without the newline.
  Outcome Read(Clock::time_point deadline, std::string* line);
  /// Ends it now. How it ended: "exited with code 3", "was killed by signal 9 (Killed)".
  std::string Kill();

 private:
  bool TakeLine(std::string* line);
  void ReadSome();
  void WriteSome();
  /// Waits until it has ended, or not longer than that.
  void AwaitEnd(Clock::time_point deadline) const;

  const std::size_t most_bytes_;
  Descriptor input_, output_;  ///< our ends
  pid_t pid_ = -1;             ///< until it is waited for
  std::string to_write_;
  std::size_t written_ = 0;  ///< of to_write_
  std::string read_;
  std::size_t searched_ = 0;  ///< of read_: no newline there
  bool ended_ = false;
  Clock::time_point finished_by_ = {};  ///< none: its stdin is open
};

}  // namespace muster
