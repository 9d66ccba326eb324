#include "tools/live/question.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "base/text.h"

namespace muster::tools {
namespace {

ChildSpec SpecOf(std::vector<std::string> command, const std::string& input,
                 const std::string& output) {
  ChildSpec spec;
  spec.name = command.front();
  spec.argv = {"/usr/bin/nice", "-n", "10", std::filesystem::read_symlink("/proc/self/exe")};
  spec.argv.insert(spec.argv.end(), command.begin(), command.end());
  spec.output_file = output;
  spec.input = input;
  return spec;
}

}  // namespace

Question::Question(std::vector<std::string> command, const std::string& input)
    : folder_("muster-question"),
      child_(SpecOf(std::move(command), input, folder_.File("answer"))) {}

std::optional<Question::Answer> Question::Poll() {
  const auto& end = child_.Poll();
  if (!end) return {};
  std::ostringstream text;
  text << std::ifstream(folder_.File("answer")).rdbuf();
  return Answer{end->clean(), text.str()};
}

std::optional<std::vector<std::string>> WhyCommand(const std::string& run,
                                                   const std::string& name) {
  const std::vector<std::string> parts = Split(name, ':');
  if (parts.size() != 2 || !ToInteger(parts[1], 0, INT32_MAX)) return {};
  if (parts[0] == "task") return {{"explain", run, "--task", parts[1]}};
  for (const char* kind : {"uav", "worker", "vehicle"}) {
    if (parts[0] == kind) return {{"explain", run, "--agent", name}};
  }
  return {};
}

}  // namespace muster::tools
