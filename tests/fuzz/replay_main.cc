// A fuzzer's target without a fuzzer: the same inputs every time, with any compiler.
//   NAME_replay SEEDS_FOLDER BEGINNINGS MUTATIONS LONGEST   see MutatedInputs
//   NAME_replay FILE...                                     these inputs, in this process

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>
#include <sstream>

#include "base/check.h"
#include "tests/fuzz/mutated_inputs.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

// Sanitizers ask for their options.
extern "C" const char* __asan_default_options() { return "max_allocation_size_mb=64"; }
extern "C" const char* __tsan_default_options() { return "max_allocation_size_mb=64"; }

namespace {

namespace fs = std::filesystem;
using muster::fuzz::MutatedInputs;

constexpr std::uint64_t kRandomSeed = 1;
constexpr unsigned kHangs_s = 120;  // an input takes milliseconds, a hundred times that sanitized

std::string Read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) throw muster::SystemError("cannot read " + file.string());
  return text.str();
}

std::vector<std::string> ReadAll(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<std::string> texts;
  for (const fs::path& file : files) texts.push_back(Read(file));
  return texts;
}

void Try(const std::string& input) {
  // As long as the input and not a byte longer, for the address sanitizer.
  const std::vector<std::uint8_t> bytes(input.begin(), input.end());
  LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
}

/// No input justifies half a gigabyte. Sanitizers need address space for themselves.
void LimitMemory() {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
  const rlimit limit{1u << 29, 1u << 29};
  setrlimit(RLIMIT_AS, &limit);
#endif
}

/// Tries all inputs in a child, so that however an input ends it, this process can say which one it
/// was.
int TryAll(const std::string& name, const MutatedInputs& inputs) {
  void* shared = mmap(nullptr, sizeof(std::atomic<std::size_t>), PROT_READ | PROT_WRITE,
                      MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) throw muster::SystemError("no shared memory");
  auto* const trying = new (shared) std::atomic<std::size_t>(0);
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw muster::SystemError("cannot fork");
  if (child == 0) {
    LimitMemory();
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      *trying = i;
      alarm(kHangs_s);
      Try(inputs.At(i));
    }
    *trying = inputs.size();
    std::exit(0);
  }
  int status = 0;
  if (waitpid(child, &status, 0) != child) throw muster::SystemError("cannot wait");
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && *trying == inputs.size()) return 0;
  const std::string end = WIFSIGNALED(status) ? std::string(strsignal(WTERMSIG(status)))
                                              : fmt::format("exit code {}", WEXITSTATUS(status));
  const std::size_t failed = *trying;
  if (failed == inputs.size()) {
    fmt::print(stderr, "{}: {} after the last input\n", name, end);
    return 1;
  }
  const std::string file = fmt::format("{}.failed-{}", name, failed);
  std::ofstream(file, std::ios::binary) << inputs.At(failed);
  fmt::print(stderr,
             "{}: {} at input {} (random seed {}). It is in {}: try it again with\n  {} {}\n", name,
             end, failed, kRandomSeed, fs::absolute(file).string(), name,
             fs::absolute(file).string());
  return 1;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string name = fs::path(argv[0]).filename();
  if (argc == 5 && fs::is_directory(argv[1])) {
    const MutatedInputs inputs(ReadAll(argv[1]), kRandomSeed,
                               {std::stoull(argv[2]), std::stoull(argv[3]), std::stoull(argv[4])});
    fmt::print("{}: {} inputs, random seed {}\n", name, inputs.size(), kRandomSeed);
    return TryAll(name, inputs);
  }
  for (int i = 1; i < argc; ++i) Try(Read(argv[i]));
  return argc == 1 ? 2 : 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "{}: {}\n", argv[0], error.what());
  return 1;
}
