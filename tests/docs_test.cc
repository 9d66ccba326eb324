// What the documentation names exists: links and their anchors, paths of the repository, commands
// of muster and their options.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace muster {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = MUSTER_SOURCE_DIR;

std::string Text(const fs::path& file) {
  std::ifstream in(file);
  EXPECT_TRUE(in.is_open()) << file;
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<fs::path> Pages() {
  std::vector<fs::path> pages = {kRoot / "README.md", kRoot / "CONTRIBUTING.md"};
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / "docs")) {
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  }
  std::sort(pages.begin(), pages.end());
  return pages;
}

std::vector<std::string> Matches(const std::string& text, const char* pattern) {
  const std::regex regex(pattern);
  std::vector<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), regex), end; it != end; ++it) {
    found.push_back((*it)[1]);
  }
  return found;
}

/// The text of the fenced blocks, and the text between them.
struct Parts {
  std::string prose, fenced;
};

Parts Split(const std::string& page) {
  Parts parts;
  bool fenced = false;
  for (std::size_t at = 0; at < page.size();) {
    const std::size_t end = std::min(page.find('\n', at), page.size() - 1) + 1;
    const std::string line = page.substr(at, end - at);
    if (line.starts_with("```")) {
      fenced = !fenced;
    } else {
      (fenced ? parts.fenced : parts.prose) += line;
    }
    at = end;
  }
  return parts;
}

/// The anchors that a page's headings get on the usual hosts.
std::set<std::string> Anchors(const fs::path& page) {
  std::set<std::string> anchors;
  for (const std::string& heading : Matches("\n" + Split(Text(page)).prose, "\n#+ ([^\n]*)")) {
    std::string anchor;
    for (const char c : heading) {
      if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_') {
        anchor += static_cast<char>(std::tolower(c));
      } else if (c == ' ') {
        anchor += '-';
      }
    }
    anchors.insert(anchor);
  }
  return anchors;
}

/// All C++ text of the product, where commands and options are declared.
const std::string& Sources() {
  static const std::string all = [] {
    std::string text;
    for (const char* folder : {"agents", "base", "recorder", "scheduler", "tools", "world"}) {
      for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
        if (entry.path().extension() == ".cc") text += Text(entry.path());
      }
    }
    return text;
  }();
  return all;
}

TEST(Docs, LinksLeadSomewhere) {
  std::size_t links = 0;
  for (const fs::path& page : Pages()) {
    for (const std::string& link : Matches(Split(Text(page)).prose, R"(\]\(([^)\s]+)\))")) {
      if (link.starts_with("http")) continue;
      ++links;
      const std::size_t hash = std::min(link.find('#'), link.size());
      const fs::path target = hash == 0 ? page : page.parent_path() / link.substr(0, hash);
      ASSERT_TRUE(fs::exists(target)) << page << " links to " << link;
      if (hash < link.size()) {
        EXPECT_TRUE(Anchors(target).contains(link.substr(hash + 1))) << page << ": " << link;
      }
    }
  }
  EXPECT_GT(links, 100u);
}

/// A path counts as one of the repository when it stands in backticks and begins with one of its
/// folders; a * stands for anything.
TEST(Docs, PathsExist) {
  std::size_t paths = 0;
  for (const fs::path& page : Pages()) {
    for (const std::string& path :
         Matches(Split(Text(page)).prose,
                 "`((?:agents|base|cmake|docs|drivers|examples|lcmtypes|learning|model|protocol|"
                 "recorder|"
                 "scenarios|scheduler|scripts|simulation|tests|tools|world)/[A-Za-z0-9_./*-]*)`")) {
      ++paths;
      const std::size_t star = std::min(path.find('*'), path.size());
      const fs::path fixed = kRoot / path.substr(0, star);
      EXPECT_TRUE(fs::exists(star < path.size() ? fixed.parent_path() : fixed))
          << page << " names " << path;
    }
  }
  EXPECT_GT(paths, 100u);
}

TEST(Docs, CommandsAndTheirOptionsExist) {
  const std::string table = Text(kRoot / "tools/cli/main.cc");
  const std::vector<std::string> declared =
      Matches(Sources(), R"re((?:Add|Flag|Group)\(\s*"([a-z0-9-]+)")re");
  std::set<std::string> options(declared.begin(), declared.end());
  // Those that have functions of their own in base/options.h, or belong to other programs.
  options.insert({"help", "version", "quiet", "json", "out", "log-level", "lcm-url"});
  // The settings of policies stand in a table.
  const std::string registry = Text(kRoot / "scheduler/policies/registry.cc");
  for (const char* setting : {"expect-arrivals", "know-shifts", "effort", "reach", "radio-loss"}) {
    EXPECT_NE(registry.find(fmt::format("     \"{}\",", setting)), registry.npos) << setting;
    options.insert(setting);
  }
  options.insert("polcy");  // the mistake in an example of an error
  std::size_t commands = 0;
  for (const fs::path& page : Pages()) {
    std::string blocks = Split(Text(page)).fenced;
    for (std::size_t at; (at = blocks.find("\\\n")) != blocks.npos;) blocks.replace(at, 2, " ");
    for (const std::string& line : Matches(blocks, R"re((?:^|\n)(?:\$ )?(muster [a-z][^\n]*))re")) {
      ++commands;
      const std::string command = Matches(line, "^muster ([a-z-]+)").at(0);
      EXPECT_NE(table.find('"' + command + '"'), table.npos) << page << ": " << line;
      // What stands in quotes, behind a pipe or in a remark is for other programs.
      std::string own = std::regex_replace(line, std::regex("'[^']*'"), "");
      own.erase(std::min({own.find(" | "), own.find(" #"), own.size()}));
      for (const std::string& option : Matches(own, " --([a-z][a-z0-9-]*)")) {
        EXPECT_TRUE(options.contains(option)) << page << ": --" << option << " in: " << line;
      }
    }
  }
  EXPECT_GT(commands, 60u);
}

}  // namespace
}  // namespace muster
