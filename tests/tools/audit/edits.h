#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/random.h"
#include "lcmtypes/bus/codec.h"
#include "tools/audit/auditor.h"

namespace muster::tools::testing {

using Packets = std::vector<Packet>;

constexpr int kEditsOfAKind = 12;

/// FNV-1a, 32 bits.
inline std::uint32_t HashOf(const std::string& text) {
  std::uint32_t hash = 2166136261u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return hash;
}

inline std::string TextOf(const std::vector<audit::Violation>& violations) {
  std::string text;
  for (const audit::Violation& v : violations) {
    text += fmt::format("{} {}: {}\n", v.at_us, v.invariant, v.text);
  }
  return text;
}

inline std::string AuditOf(const Packets& packets, bool* found) {
  audit::Auditor auditor;
  for (const Packet& packet : packets) auditor.Add(packet);
  const auto& violations = auditor.Finish();
  *found = !violations.empty();
  return fmt::format(
      "{} messages, {} twice, {} undecodable, {} ticks, {} decisions, {} activities"
      "\n{}",
      auditor.messages(), auditor.duplicates(), auditor.undecodable(), auditor.ticks(),
      auditor.decisions(), auditor.activities(), TextOf(violations));
}

/// What was said of each kind of edit of one mission.
class Findings {
 public:
  explicit Findings(std::string mission) : mission_(std::move(mission)) {}

  void Add(const std::string& kind, const Packets& edited) {
    bool found = false;
    const std::string text = AuditOf(edited, &found);
    Add(kind, found, text);
  }
  void Add(const std::string& kind, bool found, const std::string& text) {
    Kind& of = kinds_[kind];
    ++of.edits;
    of.found += found;
    of.text += text;
  }
  /// Fails where the mission's lines of that file are others.
  void ExpectThoseOf(const std::string& path) const {
    std::ifstream file(path);
    std::set<std::string> known;
    for (std::string line; std::getline(file, line);) {
      if (line.rfind(mission_ + " ", 0) == 0) known.insert(line);
    }
    for (const auto& [line, text] : Lines()) {
      EXPECT_EQ(known.erase(line), 1u) << line << "\n" << text.substr(0, 2000);
    }
    for (const std::string& line : known) ADD_FAILURE() << "no longer so: " << line;
  }
  /// Line by kind, and all that was said of it.
  std::map<std::string, std::string> Lines() const {
    std::map<std::string, std::string> lines;
    for (const auto& [name, kind] : kinds_) {
      lines[fmt::format("{} {}: {} of {}, {:08x}", mission_, name, kind.found, kind.edits,
                        HashOf(kind.text))] = kind.text;
    }
    return lines;
  }

 private:
  struct Kind {
    int edits = 0, found = 0;
    std::string text;
  };
  std::string mission_;
  std::map<std::string, Kind> kinds_;
};

/// Edits one message of a type at a time: `edit` does the i-th edit of its kind to a message, at a
/// place that it draws; false where there is nothing to edit.
template <class Message>
using Editor = std::function<bool(Message&, int, Random*)>;

template <class Message>
void Edit(Findings* findings, const Packets& packets, const std::string& kind,
          const Editor<Message>& edit) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    if (Decode<Message>(packets[i].bytes)) places.push_back(i);
  }
  if (places.empty()) return;
  Random random(HashOf(kind), Stream::kTest);
  int done = 0;
  for (int tried = 0; done < kEditsOfAKind && tried < 6 * kEditsOfAKind; ++tried) {
    const std::size_t i = places[random.Below(static_cast<std::uint32_t>(places.size()))];
    Message message = *Decode<Message>(packets[i].bytes);
    if (!edit(message, done, &random)) continue;
    ++done;
    Packets edited = packets;
    edited[i].bytes = Encode(message);
    findings->Add(kind, edited);
  }
}

/// The i-th change of a value: up and down, by what tolerances pass and what they do not, by much.
template <class T>
void Change(T* value, int i) {
  if constexpr (std::is_floating_point_v<T>) {
    constexpr double kBy[] = {9e-4, -9e-4, 1.1e-3, -1.1e-3, 1,   -1,
                              100,  -100,  1e-7,   -1e-7,   5e3, -5e3};
    *value += kBy[i % 12];
  } else if constexpr (sizeof(T) == 8) {
    constexpr std::int64_t kBy[] = {1, -1, 2, -2, 3, -3, 1000, -1000, 150'000'000, -150'000'000};
    // Around the ends, as nothing keeps a header from saying so.
    const auto moved = static_cast<T>(static_cast<std::uint64_t>(*value) +
                                      static_cast<std::uint64_t>(kBy[i % 12 % 10]));
    *value = i % 12 < 10 ? moved : i % 12 == 10 ? 0 : INT64_MAX;
  } else {
    constexpr int kBy[] = {1, -1, 2, -2, 3, -3, 7, -7};
    *value = static_cast<T>(i % 10 < 8 ? *value + kBy[i % 10] : i % 10 == 8 ? -1 : 0);
  }
}

template <class Message, class T>
Editor<Message> Field(T Message::*field) {
  return [=](Message& message, int i, Random*) {
    Change(&(message.*field), i);
    return true;
  };
}

/// A field of an item of the message's list.
template <class Message, class Item, class T>
Editor<Message> ItemField(std::vector<Item> Message::*list, T Item::*field) {
  return [=](Message& message, int i, Random* random) {
    auto& items = message.*list;
    if (items.empty()) return false;
    Change(&(items[random->Below(static_cast<std::uint32_t>(items.size()))].*field), i);
    return true;
  };
}

/// An item that is gone or there twice.
template <class Message, class Item>
Editor<Message> ItemGoneOrTwice(std::vector<Item> Message::*list, std::int32_t Message::*count) {
  return [=](Message& message, int i, Random* random) {
    auto& items = message.*list;
    if (items.empty()) return false;
    const auto at = items.begin() + random->Below(static_cast<std::uint32_t>(items.size()));
    if (i % 2 == 0) {
      items.erase(at);
    } else {
      items.push_back(*at);
    }
    message.*count = static_cast<std::int32_t>(items.size());
    return true;
  };
}

}  // namespace muster::tools::testing
