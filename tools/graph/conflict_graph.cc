#include "tools/graph/conflict_graph.h"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <algorithm>
#include <cmath>
#include <istream>
#include <limits>
#include <nlohmann/json.hpp>
#include <ostream>
#include <sstream>

#include "base/check.h"
#include "base/text.h"

namespace muster::tools {

using scheduler::Node;

ConflictGraph::ConflictGraph(scheduler::Situation situation)
    : situation_(std::move(situation)), candidates_(scheduler::EnumerateCandidates(situation_)) {
  at_element_.resize(static_cast<std::size_t>(candidates_.elements.size()));
  for (std::int32_t i = 0; i < n_nodes(); ++i) {
    for (const std::int32_t e :
         ElementsOf(nodes()[static_cast<std::size_t>(i)], candidates_.elements)) {
      at_element_[static_cast<std::size_t>(e)].push_back(i);
    }
  }
  mark_.assign(nodes().size(), -1);
}

void ConflictGraph::Neighbours(std::int32_t node, std::vector<std::int32_t>* neighbours) const {
  neighbours->clear();
  mark_[static_cast<std::size_t>(node)] = node;
  for (const std::int32_t e :
       ElementsOf(nodes()[static_cast<std::size_t>(node)], candidates_.elements)) {
    if (candidates_.elements.capacity[static_cast<std::size_t>(e)] != 1) continue;
    for (const std::int32_t other : at_element_[static_cast<std::size_t>(e)]) {
      if (mark_[static_cast<std::size_t>(other)] == node) continue;
      mark_[static_cast<std::size_t>(other)] = node;
      neighbours->push_back(other);
    }
  }
  std::sort(neighbours->begin(), neighbours->end());
}

void ConflictGraph::WriteMetis(std::ostream& out, double scale) const {
  const auto& capacity = candidates_.elements.capacity;
  for (std::size_t e = 0; e < capacity.size(); ++e) {
    if (capacity[e] > 1 && static_cast<std::size_t>(capacity[e]) < at_element_[e].size()) {
      throw InputError(fmt::format(
          "{} has {} free places, which edges between two nodes cannot express: use --format mps",
          candidates_.NameOf(static_cast<std::int32_t>(e)), capacity[e]));
    }
  }
  std::vector<std::int32_t> neighbours;
  std::int64_t degrees = 0;
  for (std::int32_t i = 0; i < n_nodes(); ++i) {
    Neighbours(i, &neighbours);
    degrees += static_cast<std::int64_t>(neighbours.size());
  }
  std::fill(mark_.begin(), mark_.end(), -1);
  fmt::print(out, "{} {} 10\n", n_nodes(), degrees / 2);
  fmt::memory_buffer line;
  for (std::int32_t i = 0; i < n_nodes(); ++i) {
    Neighbours(i, &neighbours);
    line.clear();
    fmt::format_to(std::back_inserter(line), "{}",
                   std::llround(nodes()[static_cast<std::size_t>(i)].weight * scale));
    for (const std::int32_t other : neighbours) {
      fmt::format_to(std::back_inserter(line), " {}", other + 1);
    }
    line.push_back('\n');
    out.write(line.data(), static_cast<std::streamsize>(line.size()));
  }
  std::fill(mark_.begin(), mark_.end(), -1);
}

void ConflictGraph::WriteMps(std::ostream& out) const {
  fmt::print(out, "NAME decision_{}\nROWS\n N minus_weight\n", situation_.decision);
  const auto& capacity = candidates_.elements.capacity;
  const auto limited = [&](std::int32_t e) {
    // Agents' rows bound every node by 1 as well, so that no bounds are needed.
    const auto at = static_cast<std::size_t>(e);
    return e < candidates_.elements.n_agents() ||
           static_cast<std::size_t>(capacity[at]) < at_element_[at].size();
  };
  for (std::int32_t e = 0; e < candidates_.elements.size(); ++e) {
    if (limited(e)) fmt::print(out, " L {}\n", candidates_.NameOf(e));
  }
  out << "COLUMNS\n M1 'MARKER' 'INTORG'\n";
  for (std::int32_t i = 0; i < n_nodes(); ++i) {
    const Node& node = nodes()[static_cast<std::size_t>(i)];
    fmt::print(out, " n{} minus_weight {}\n", i, -node.weight);
    for (const std::int32_t e : ElementsOf(node, candidates_.elements)) {
      if (limited(e)) fmt::print(out, " n{} {} 1\n", i, candidates_.NameOf(e));
    }
  }
  out << " M2 'MARKER' 'INTEND'\nRHS\n";
  for (std::int32_t e = 0; e < candidates_.elements.size(); ++e) {
    if (limited(e)) {
      fmt::print(out, " rhs {} {}\n", candidates_.NameOf(e), capacity[static_cast<std::size_t>(e)]);
    }
  }
  out << "ENDATA\n";
}

void ConflictGraph::WriteJson(std::ostream& out) const {
  // Line by line: a document in memory would be many times the graph.
  fmt::print(out, "{{\"version\": 1, \"decision\": {},\n \"elements\": [", situation_.decision);
  const auto& capacity = candidates_.elements.capacity;
  for (std::int32_t e = 0; e < candidates_.elements.size(); ++e) {
    const std::int32_t admits = capacity[static_cast<std::size_t>(e)];
    fmt::print(
        out, "{}\n  {{\"name\": \"{}\", \"admits\": {}}}", e == 0 ? "" : ",", candidates_.NameOf(e),
        admits == std::numeric_limits<std::int32_t>::max() ? "null" : fmt::to_string(admits));
  }
  out << "],\n \"nodes\": [";
  for (std::int32_t i = 0; i < n_nodes(); ++i) {
    const Node& node = nodes()[static_cast<std::size_t>(i)];
    nlohmann::ordered_json line;
    line["kind"] = ToString(node.kind);
    line["weight"] = node.weight;
    line["elements"] = nlohmann::ordered_json::array();
    for (const std::int32_t e : ElementsOf(node, candidates_.elements)) {
      line["elements"].push_back(e);
    }
    out << (i == 0 ? "\n  " : ",\n  ") << line.dump();
  }
  out << "]}\n";
}

ConflictGraph::Verdict ConflictGraph::Check(std::span<const std::int32_t> chosen) const {
  Verdict verdict;
  std::vector<std::vector<std::int32_t>> users(at_element_.size());
  std::vector<std::int32_t> sorted(chosen.begin(), chosen.end());
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  for (const std::int32_t i : sorted) {
    const Node& node = nodes()[static_cast<std::size_t>(i)];
    verdict.weight += node.weight;
    for (const std::int32_t e : ElementsOf(node, candidates_.elements)) {
      users[static_cast<std::size_t>(e)].push_back(i);
    }
  }
  for (std::size_t e = 0; e < users.size(); ++e) {
    const auto admits = static_cast<std::size_t>(candidates_.elements.capacity[e]);
    if (users[e].size() <= admits) continue;
    std::string text = fmt::format("{} admits {}, chosen are",
                                   candidates_.NameOf(static_cast<std::int32_t>(e)), admits);
    for (const std::int32_t i : users[e]) {
      text += fmt::format(
          " {} ({})", i,
          ToString(candidates_.ToAction(situation_, nodes()[static_cast<std::size_t>(i)])));
    }
    verdict.conflicts.push_back(std::move(text));
  }
  return verdict;
}

std::vector<std::int32_t> ReadSolution(std::istream& in, const std::string& file,
                                       const std::string& form, std::int32_t n_nodes) {
  std::vector<std::int32_t> chosen;
  const std::int32_t first = form == "nodes-from-1" ? 1 : 0;
  const auto number = [&](std::string_view text, const std::string& where) {
    const auto value = ToInteger(text, first, first + n_nodes - 1);
    if (!value) {
      throw InputError(file, where, std::string(text),
                       fmt::format("a node number from {} to {}", first, first + n_nodes - 1));
    }
    return static_cast<std::int32_t>(*value) - first;
  };
  std::string line;
  std::int32_t at = 0;
  for (int n = 1; std::getline(in, line); ++n) {
    const std::string where = fmt::format("line {}", n);
    std::istringstream words(line);
    std::string word;
    if (form == "indicator") {
      if (!(words >> word)) continue;
      std::string more;
      if ((word != "0" && word != "1") || words >> more) {
        throw InputError(file, where, line, "0 or 1");
      }
      if (at >= n_nodes) {
        throw InputError(file, where, "another line", fmt::format("{} lines", n_nodes));
      }
      if (word == "1") chosen.push_back(at);
      ++at;
    } else if (form == "nodes" || form == "nodes-from-1") {
      while (words >> word) chosen.push_back(number(word, where));
    } else if (form == "mps") {
      while (words >> word) {
        if (word.size() < 2 || word[0] != 'n' || word[1] < '0' || word[1] > '9') continue;
        const std::int32_t node = number(std::string_view(word).substr(1), where);
        double value = 0;
        if (!(words >> value)) throw InputError(file, where, line, "a value after " + word);
        if (std::abs(value - std::round(value)) > 1e-4 || value < -1e-4 || value > 1 + 1e-4) {
          throw InputError(file, where, fmt::to_string(value), "0 or 1");
        }
        if (value > 0.5) chosen.push_back(node);
        break;
      }
    } else {
      throw InputError("options", "--form", form, "indicator, nodes, nodes-from-1 or mps");
    }
  }
  if (form == "indicator" && at != n_nodes) {
    throw InputError(file, "end", fmt::format("{} lines", at), fmt::format("{} lines", n_nodes));
  }
  return chosen;
}

}  // namespace muster::tools
