#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace muster {

/// An open file, never one of stdin, stdout and stderr (even where our caller closed those), that
/// closes itself.
class Descriptor {
 public:
  /// Takes fd over; a negative one stays so.
  explicit Descriptor(int fd = -1);
  ~Descriptor() { Close(); }
  Descriptor(Descriptor&& other) noexcept : fd_(other.Release()) {}
  Descriptor& operator=(Descriptor&& other) noexcept;
  int get() const { return fd_; }
  void Close();
  /// Gives it away, open.
  int Release();

 private:
  int fd_;
};

/// A pipe whose ends no program that is started inherits.
struct Pipe {
  Descriptor read_end, write_end;
};
/// None when there are too many open files; errno says so.
std::optional<Pipe> MakePipe();

/// Whether a program that asks for it, by fdatasync(2), waits until what it has written is on disk.
enum class DiskWaits {
  kAsIs,
  kSkipped,  ///< where the kernel lets: it goes on at once, and a power cut may cost half a minute
};

/// Starts the program `argv[0]`, a path, with these three open files as its stdin, stdout and
/// stderr, and no other. It runs in a process group of its own (a terminal's Ctrl-C reaches the
/// parent alone, which ends its children in order), with all signals as a shell would leave them,
/// and is killed by the kernel when the thread that started it ends in any way. Returns its id, to
/// be waited for. Throws SystemError ("cannot start ...") when it cannot be executed.
pid_t Spawn(std::vector<std::string> argv, int input, int output, int error,
            DiskWaits disk_waits = DiskWaits::kAsIs);

/// The program that a shell would start under that name: a path as it is, else the first
/// executable file of that name in PATH; none: there is none.
std::optional<std::string> FindProgram(const std::string& name);

}  // namespace muster
