#include "tools/map/ogr.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "base/check.h"
#include "base/spawn.h"
#include "base/text.h"

namespace muster::tools {
namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

/// The program while it runs: its stdout is a pipe, its stderr a file without a name.
class Ogr {
 public:
  explicit Ogr(std::vector<std::string> argv) : errors_(std::tmpfile(), &std::fclose) {
    std::optional<Pipe> pipe = MakePipe();
    const Descriptor nothing(open("/dev/null", O_RDONLY | O_CLOEXEC));
    if (!pipe || !errors_ || nothing.get() < 0) {
      throw SystemError(fmt::format("cannot start ogr2ogr: {}", std::strerror(errno)));
    }
    pid_ = Spawn(std::move(argv), nothing.get(), pipe->write_end.get(), ::fileno(errors_.get()));
    output_ = std::move(pipe->read_end);
  }
  ~Ogr() {
    if (pid_ < 0) return;
    kill(pid_, SIGKILL);
    Wait();
  }
  Ogr(const Ogr&) = delete;
  Ogr& operator=(const Ogr&) = delete;

  void ReadLines(const std::function<void(std::string_view)>& take) {
    std::string text;
    std::array<char, 1 << 16> part;
    for (;;) {
      const ssize_t n = read(output_.get(), part.data(), part.size());
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) break;
      text.append(part.data(), static_cast<std::size_t>(n));
      std::size_t begin = 0;
      for (std::size_t end; (end = text.find('\n', begin)) != text.npos; begin = end + 1) {
        take(std::string_view(text).substr(begin, end - begin));
      }
      text.erase(0, begin);
    }
    if (!text.empty()) take(text);
  }

  /// Its first error; "": it ended well. It may end with 0 where it has told one.
  std::string Finish() {
    const int status = Wait();
    std::rewind(errors_.get());
    std::array<char, 1 << 12> part;  // its first words say what matters
    const std::size_t n = std::fread(part.data(), 1, part.size(), errors_.get());
    const std::vector<std::string> lines = Split({part.data(), n}, '\n');
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (lines[i].starts_with("ERROR ")) return Printable(lines[i]);
      if (lines[i] == "FAILURE:" && i + 1 < lines.size()) {
        // Then follows all that it could have been.
        return Printable(lines[i + 1].substr(0, lines[i + 1].find(" with the following drivers")));
      }
    }
    if (status == 0) return "";
    return WIFSIGNALED(status) ? fmt::format("it was killed by signal {}", WTERMSIG(status))
                               : fmt::format("it exited with code {}", WEXITSTATUS(status));
  }

 private:
  int Wait() {
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = -1;
    return status;
  }

  File errors_;
  Descriptor output_;
  pid_t pid_ = -1;
};

}  // namespace

void ReadByOgr(const std::string& file, const std::vector<std::string>& layer,
               std::string_view expected, const std::function<void(std::string_view)>& take) {
  const std::optional<std::string> program = FindProgram("ogr2ogr");
  if (!program) {
    throw InputError(fmt::format(
        "{}: found no program ogr2ogr to read it, expected that of GDAL (apt-get install gdal-bin)",
        file));
  }
  // The whole path: no name is an option or one of GDAL's own file systems.
  std::vector<std::string> argv = {*program, "-f", "GeoJSONSeq", "/vsistdout/",
                                   std::filesystem::absolute(file).string()};
  argv.insert(argv.end(), layer.begin(), layer.end());
  for (const char* option : {"-lco", "COORDINATE_PRECISION=7", "--config", "CPL_TMPDIR"}) {
    argv.emplace_back(option);
  }
  argv.push_back(std::filesystem::temp_directory_path().string());
  Ogr ogr(std::move(argv));
  ogr.ReadLines(take);
  if (const std::string error = ogr.Finish(); !error.empty()) {
    throw InputError(file, "content", fmt::format("what ogr2ogr cannot read ({})", error),
                     expected);
  }
}

}  // namespace muster::tools
