#include "base/text_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "base/check.h"

namespace muster {
namespace {

/// Of what a file or a pipe holds, the first line or as much of it as there may be.
std::string FirstLine(int fd, const std::string& from, std::size_t most_bytes) {
  std::string text;
  char c = 0;
  while (text.size() < most_bytes) {
    const ssize_t got = read(fd, &c, 1);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw InputError(fmt::format("{}: {}", from, std::strerror(errno)));
    if (got == 0 || c == '\n') break;
    text += c;
  }
  return text;
}

}  // namespace

std::string ReadSecretLine(const std::string& file, std::string_view what, std::size_t most_bytes) {
  if (file == "-") return FirstLine(STDIN_FILENO, "stdin", most_bytes);
  const int fd = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  if (fd < 0 || fstat(fd, &status) != 0) {
    const int error = errno;
    if (fd >= 0) close(fd);
    throw InputError(fmt::format("{}: {}", file, std::strerror(error)));
  }
  std::string text;
  const mode_t others = status.st_mode & (S_IRWXG | S_IRWXO);
  // A pipe belongs to the processes that hold its ends.
  const bool open_to_others = S_ISREG(status.st_mode) && others != 0;
  try {
    if (!open_to_others) text = FirstLine(fd, file, most_bytes);
  } catch (...) {
    close(fd);
    throw;
  }
  close(fd);
  if (open_to_others) {
    throw InputError(file, "mode", fmt::format("{:04o}", status.st_mode & 07777U),
                     fmt::format("a {} that its owner alone can read (chmod 600)", what));
  }
  return text;
}

std::string ReadTextFile(const std::string& file, std::string_view what, std::size_t most_bytes) {
  const auto refusal = [&](const std::string& reason) {
    return InputError(fmt::format("{}: cannot read {} from it: {}", file, what, reason));
  };
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(file.c_str(), "rb"),
                                                           &std::fclose);
  if (!in) throw refusal(std::strerror(errno));
  std::string text;
  std::array<char, 1 << 16> part;
  while (const std::size_t n = std::fread(part.data(), 1, part.size(), in.get())) {
    if (n > most_bytes - text.size()) {
      throw refusal(fmt::format("found more than {} bytes", most_bytes));
    }
    text.append(part.data(), n);
  }
  if (std::ferror(in.get()) != 0) throw refusal(std::strerror(errno));
  return text;
}

}  // namespace muster
