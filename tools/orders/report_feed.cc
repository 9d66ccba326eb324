#include "tools/orders/report_feed.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <set>
#include <thread>
#include <utility>

#include "base/check.h"
#include "base/say.h"
#include "base/sha256.h"
#include "tools/files/pending_file.h"
#include "tools/orders/feed_rows.h"
#include "tools/orders/order_socket.h"
#include "tools/orders/web_client.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using std::chrono::milliseconds;

constexpr int kMostSaid = 20;               ///< refusals in words
constexpr double kSamePlaceDeg = 2e-4;      ///< some 20 m
constexpr auto kPause = milliseconds(200);  ///< at signals and at the mission's end

std::string ReadOne(std::istream& in, const std::string& name) {
  std::string text;
  std::vector<char> part(1 << 16);
  while (in.read(part.data(), static_cast<std::streamsize>(part.size())) || in.gcount() > 0) {
    text.append(part.data(), static_cast<std::size_t>(in.gcount()));
    if (text.size() > DocumentSource::kMostBytes) {
      throw InputError(
          fmt::format("{}: larger than {} MiB", name, DocumentSource::kMostBytes >> 20));
    }
  }
  return text;
}

/// A task that a report has become.
struct Given {
  std::int64_t task = 0;
  double latitude = 0, longitude = 0;
};

/// What was given of a report. One that was replaced, or refused, has no tasks.
struct Entry {
  std::string version;
  int n_changes = 0;
  std::vector<Given> tasks;
};

/// The reports that were given.
class Memory {
 public:
  explicit Memory(std::string file) : file_(std::move(file)) {
    const std::string text = ReadFile(file_);
    if (text.empty()) return;
    try {
      const Json json = Json::parse(text);
      for (const auto& [key, entry] : json.items()) {
        Entry& known = given[key];
        known.version = entry.value("version", "");
        known.n_changes = entry.value("changes", 0);
        for (const Json& task : entry.at("tasks")) {
          known.tasks.push_back(
              {task.at(0).get<std::int64_t>(), task.at(1).get<double>(), task.at(2).get<double>()});
        }
      }
    } catch (const Json::exception&) {
      throw InputError(fmt::format("{}: damaged; remove it to give everything again", file_));
    }
  }
  void Save() const {
    Json json = Json::object();
    for (const auto& [key, entry] : given) {
      Json& said = json[key] = Json::object();
      if (!entry.version.empty()) said["version"] = entry.version;
      if (entry.n_changes > 0) said["changes"] = entry.n_changes;
      said["tasks"] = Json::array();
      for (const Given& task : entry.tasks)
        said["tasks"].push_back({task.task, task.latitude, task.longitude});
    }
    WriteFile(file_, json.dump(1) + "\n");
  }
  bool Knows(const Report& report) const {
    const auto entry = given.find(report.key);
    return entry != given.end() && entry->second.version == report.version;
  }

  std::map<std::string, Entry> given;

 private:
  const std::string file_;
};

class Feeder {
 public:
  Feeder(const FeedSettings& settings, const StopSignals& stop)
      : settings_(settings),
        stop_(stop),
        client_(settings.run, settings.key_file),
        memory_((fs::path(settings.run) / settings.memory).string()) {}

  void Look(const DocumentSource& source) {
    std::vector<Report> reports;
    const auto documents = source.Read();
    for (const auto& [name, text] : documents) {
      if (!documents_.insert(Sha256(text)).second) continue;
      try {
        Reports read = settings_.read(text, name);
        for (const std::string& why : read.refused) RefuseOnce(why);
        std::move(read.reports.begin(), read.reports.end(), std::back_inserter(reports));
      } catch (const InputError& error) {
        if (settings_.every_s == 0 && documents.size() == 1) throw;
        RefuseOnce(error.what());
      }
    }
    std::stable_sort(reports.begin(), reports.end(),
                     [](const Report& a, const Report& b) { return a.sent < b.sent; });
    bool is_new = false;
    for (const Report& report : reports) {
      if (Ended() || memory_.Knows(report)) continue;
      is_new = true;
      Give(report);
    }
    HearAll();
    // If it was interrupted, all of this look is given again: the orders are then the same ones.
    if (is_new && open_.empty() && stop_.count() == 0) memory_.Save();
  }

  bool Ended() {
    if (!client_.gone()) HearOne(milliseconds(0));
    return client_.gone() || stop_.count() > 0;
  }

  FeedCounts counts;

 private:
  /// What stays wrong from look to look is one refusal.
  void RefuseOnce(const std::string& why) {
    if (refused_.insert(why).second) Refuse(why);
  }
  void Refuse(const std::string& why) {
    if (++counts.refused <= kMostSaid) Say("muster: refused: {}\n", why);
    if (counts.refused == kMostSaid) Say("muster: further refusals are only counted\n");
  }

  void Give(const Report& report) {
    std::vector<Given> before;
    std::vector<std::string> replaced = report.replaces;
    if (memory_.given.contains(report.key)) replaced.push_back(report.key);
    if (!replaced.empty()) HearAll();
    for (const std::string& key : replaced) {
      std::vector<Given> old = std::exchange(memory_.given[key].tasks, {});
      before.insert(before.end(), old.begin(), old.end());
    }
    Entry& entry = memory_.given[report.key];
    if (!report.version.empty() && !entry.version.empty()) ++entry.n_changes;
    entry.version = report.version;
    std::string known_by = report.key;
    if (!report.version.empty()) known_by += fmt::format(" {} {}", report.version, entry.n_changes);
    int n = 0;
    const auto id = [&] {
      return fmt::format("{}-{}", settings_.format,
                         Sha256(fmt::format("{} {}", known_by, n++)).substr(0, 32));
    };
    for (const Json& task : report.tasks) {
      const double latitude = task.at("latitude_deg").get<double>();
      const double longitude = task.at("longitude_deg").get<double>();
      const auto same = std::find_if(before.begin(), before.end(), [&](const Given& old) {
        return std::abs(old.latitude - latitude) < kSamePlaceDeg &&
               std::abs(old.longitude - longitude) < kSamePlaceDeg;
      });
      if (same != before.end()) {
        Json order = {
            {"id", id()}, {"issuer", "feed"}, {"order", "task_change"}, {"task", same->task}};
        for (const char* key :
             {"priority", "name", "due_min", "due_in_min", "expires_min", "expires_in_min"}) {
          if (task.contains(key)) order[key] = task[key];
        }
        Send(order, {report.key, *same});
        before.erase(same);
      } else {
        Send(AddOrder(id(), task), {report.key, {kNone, latitude, longitude}});
      }
    }
    for (const Given& old : before) {
      Send({{"id", id()}, {"issuer", "feed"}, {"order", "task_cancel"}, {"task", old.task}},
           {report.key, {kCancelled, 0, 0}});
    }
  }

  /// An order without an answer: the report it is of, and the task that it gives. A task that was
  /// there before stays one of the report even if the change is refused.
  struct Open {
    std::string key;
    Given task;
  };
  /// In the place of its number: it is not known yet, or the task is being cancelled.
  static constexpr std::int64_t kNone = -1, kCancelled = -2;

  void Send(const Json& order, const Open& open) {
    while (open_.size() >= kMostOpen && CanHear()) HearOne(kPause);
    if (!CanHear()) return;
    client_.Send(order.dump());
    open_.emplace(order.at("id").get<std::string>(), open);
  }
  bool CanHear() const { return !client_.gone() && stop_.count() == 0; }
  void HearAll() {
    while (!open_.empty() && CanHear()) HearOne(kPause);
    if (!open_.empty() && stop_.count() == 0) {
      throw SystemError(
          fmt::format("the mission has ended; {} orders had no answer", open_.size()));
    }
  }
  void HearOne(milliseconds wait) {
    const std::string text = client_.Receive(wait);
    if (text.empty()) return;
    const Json answer = Json::parse(text);
    const auto open = open_.find(answer.value("id", ""));
    if (open == open_.end()) return;
    auto [key, task] = open->second;
    open_.erase(open);
    const bool is_taken = answer.contains("taken");
    if (is_taken) {
      ++counts.taken;
      if (task.task == kNone) task.task = answer["taken"].value("task", std::int64_t{0});
    } else {
      Refuse(answer.value(answer.contains("refused") ? "refused" : "error", ""));
    }
    if (task.task >= 0) memory_.given[key].tasks.push_back(task);
  }

  const FeedSettings& settings_;
  const StopSignals& stop_;
  OrderClient client_;
  Memory memory_;
  std::map<std::string, Open> open_;  ///< by the order's id
  std::set<std::string> documents_;   ///< SHA-256 of those that were read
  std::set<std::string> refused_;
};

}  // namespace

DocumentSource::DocumentSource(std::string from, std::vector<std::string> endings,
                               std::string token,
                               std::function<std::string(const std::string&)> next_page)
    : from_(std::move(from)),
      endings_(std::move(endings)),
      token_(std::move(token)),
      next_page_(std::move(next_page)) {
  std::error_code ignored;
  if (from_ != "-" && !IsWebAddress(from_) && !fs::exists(from_, ignored)) {
    throw InputError(fmt::format("{}: no such file or folder", from_));
  }
}

std::vector<std::pair<std::string, std::string>> DocumentSource::Read() const {
  if (from_ == "-") return {{"stdin", ReadOne(std::cin, "stdin")}};
  if (IsWebAddress(from_)) return ReadPages();
  std::vector<std::string> files;
  if (fs::is_directory(from_)) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(from_, error)) {
      const std::string name = entry.path().filename().string();
      const bool fits =
          std::any_of(endings_.begin(), endings_.end(),
                      [&](const std::string& ending) { return name.ends_with(ending); });
      if (fits && !name.starts_with('.') && entry.is_regular_file())
        files.push_back(entry.path().string());
    }
    if (error) throw InputError(fmt::format("{}: cannot read it: {}", from_, error.message()));
    std::sort(files.begin(), files.end());
  } else {
    files.push_back(from_);
  }
  std::vector<std::pair<std::string, std::string>> documents;
  for (const std::string& file : files) {
    std::ifstream in(file, std::ios::binary);
    if (!in.is_open()) throw InputError(fmt::format("{}: cannot read it", file));
    documents.emplace_back(file, ReadOne(in, file));
  }
  return documents;
}

std::vector<std::pair<std::string, std::string>> DocumentSource::ReadPages() const {
  std::vector<std::pair<std::string, std::string>> pages;
  std::set<std::string> read;
  std::size_t n_bytes = 0;
  for (std::string address = from_; !address.empty();) {
    if (!read.insert(address).second)
      throw SystemError(fmt::format("{}: its next page is one that was read", address));
    std::string page = Fetch(address, token_, kMostBytes - n_bytes);
    n_bytes += page.size();
    const std::string next = next_page_ ? next_page_(page) : "";
    pages.emplace_back(address, std::move(page));
    address = next.empty() ? "" : OnTheSameServer(next, from_);
  }
  return pages;
}

FeedCounts FeedReports(const DocumentSource& source, const FeedSettings& settings,
                       const StopSignals& stop) {
  Feeder feeder(settings, stop);
  std::string trouble;
  while (!feeder.Ended()) {
    try {
      feeder.Look(source);
      trouble.clear();
    } catch (const std::exception& error) {
      // A server or a folder that is away comes back; the mission does not.
      if (settings.every_s == 0 || feeder.Ended()) throw;
      if (trouble != error.what()) Say("muster: {}\n", error.what());
      trouble = error.what();
    }
    if (settings.every_s == 0) break;
    const auto next = std::chrono::steady_clock::now() +
                      milliseconds(static_cast<std::int64_t>(settings.every_s * 1000));
    while (!feeder.Ended() && std::chrono::steady_clock::now() < next)
      std::this_thread::sleep_for(kPause);
  }
  return feeder.counts;
}

}  // namespace muster::tools
