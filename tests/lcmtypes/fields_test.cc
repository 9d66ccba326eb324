// The generated visitors name every field of every .lcm file, in its order.
#include "muster/fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace muster {
namespace {

namespace fs = std::filesystem;

struct Names {
  std::vector<std::string> names;
  template <class T>
  void operator()(const char* name, const T&) {
    names.emplace_back(name);
  }
  void Count(const char* name, std::int32_t) { names.push_back(std::string("#") + name); }
  template <class T>
  void Array(const char* name, const std::vector<T>&, std::int32_t) {
    names.push_back(std::string(name) + "[]");
  }
};

template <class T>
void Add(std::map<std::string, std::vector<std::string>>* all) {
  const T message{};
  Names names;
  VisitFields(names, message);
  (*all)[T::getTypeName()] = names.names;
}

/// The same, read from the text of a file, word by word.
std::vector<std::string> NamesIn(const fs::path& file) {
  std::ifstream in(file);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  std::string plain = std::regex_replace(text, std::regex("//[^\n]*"), "");
  plain = plain.substr(plain.find('{') + 1);
  std::vector<std::string> names;
  std::istringstream fields(plain.substr(0, plain.find('}')));
  for (std::string field; std::getline(fields, field, ';');) {
    std::istringstream words(std::regex_replace(field, std::regex(","), " "));
    std::string word;
    if (!(words >> word)) continue;  // its type
    while (words >> word) {
      const std::size_t bracket = word.find('[');
      if (bracket == word.npos) {
        names.push_back(word);
        continue;
      }
      const std::string count = word.substr(bracket + 1, word.size() - bracket - 2);
      *std::find(names.begin(), names.end(), count) = "#" + count;
      names.push_back(word.substr(0, bracket) + "[]");
    }
  }
  return names;
}

TEST(VisitFields, NamesEveryFieldOfEveryFile) {
  std::map<std::string, std::vector<std::string>> visited;
  Add<action_t>(&visited), Add<activity_t>(&visited), Add<agent_changes_t>(&visited);
  Add<agent_states_t>(&visited), Add<agent_t>(&visited), Add<answer_t>(&visited);
  Add<clearance_t>(&visited), Add<clearances_t>(&visited);
  Add<proposal_t>(&visited);
  Add<clock_t>(&visited), Add<event_t>(&visited), Add<fault_t>(&visited);
  Add<header_t>(&visited), Add<log_mark_t>(&visited), Add<log_status_t>(&visited);
  Add<order_book_t>(&visited), Add<order_t>(&visited), Add<orders_t>(&visited);
  Add<process_status_t>(&visited), Add<refused_order_t>(&visited), Add<request_t>(&visited);
  Add<restore_t>(&visited), Add<roads_t>(&visited);
  Add<ruling_t>(&visited), Add<rulings_t>(&visited);
  Add<scenario_t>(&visited), Add<schedule_t>(&visited), Add<taken_order_t>(&visited);
  Add<world_state_t>(&visited);
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(MUSTER_SOURCE_DIR) / "lcmtypes/types")) {
    ++files;
    EXPECT_EQ(visited[entry.path().stem()], NamesIn(entry.path())) << entry.path();
  }
  EXPECT_EQ(files, visited.size());
}

}  // namespace
}  // namespace muster
