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

#include "base/check.h"
#include "base/say.h"
#include "base/sha256.h"
#include "tools/files/pending_file.h"
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

/// What was given of each report. A report that was replaced, or refused, has nothing.
class Memory {
 public:
  explicit Memory(std::string file) : file_(std::move(file)) {
    const std::string text = ReadFile(file_);
    if (text.empty()) return;
    try {
      const Json json = Json::parse(text);
      for (const auto& [key, tasks] : json.items()) {
        for (const Json& task : tasks) {
          given[key].push_back(
              {task.at(0).get<std::int64_t>(), task.at(1).get<double>(), task.at(2).get<double>()});
        }
        given[key];
      }
    } catch (const Json::exception&) {
      throw InputError(fmt::format("{}: damaged; remove it to give everything again", file_));
    }
  }
  void Save() const {
    Json json = Json::object();
    for (const auto& [key, tasks] : given) {
      json[key] = Json::array();
      for (const Given& task : tasks)
        json[key].push_back({task.task, task.latitude, task.longitude});
    }
    WriteFile(file_, json.dump(1) + "\n");
  }

  std::map<std::string, std::vector<Given>> given;

 private:
  const std::string file_;
};

class Feeder {
 public:
  Feeder(const FeedSettings& settings, const StopSignals& stop)
      : settings_(settings),
        stop_(stop),
        client_(settings.run),
        memory_((fs::path(settings.run) / settings.memory).string()) {}

  void Look(const DocumentSource& source) {
    std::vector<Report> reports;
    for (const auto& [name, text] : source.Read()) {
      if (!documents_.insert(Sha256(text)).second) continue;
      try {
        Reports read = settings_.read(text, name);
        for (const std::string& why : read.refused) RefuseOnce(why);
        std::move(read.reports.begin(), read.reports.end(), std::back_inserter(reports));
      } catch (const InputError& error) {
        RefuseOnce(error.what());
      }
    }
    std::stable_sort(reports.begin(), reports.end(),
                     [](const Report& a, const Report& b) { return a.sent < b.sent; });
    bool is_new = false;
    for (const Report& report : reports) {
      if (Ended() || memory_.given.contains(report.key)) continue;
      is_new = true;
      Give(report);
    }
    if (is_new) memory_.Save();
  }

  bool Ended() {
    // Nothing is asked: what comes is the end.
    if (!client_.gone()) client_.Receive(milliseconds(0));
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
    std::vector<Given> before, now;
    for (const std::string& key : report.replaces) {
      std::vector<Given>& old = memory_.given[key];
      before.insert(before.end(), old.begin(), old.end());
      old.clear();
    }
    int n = 0;
    const auto id = [&] {
      return fmt::format("{}-{}", settings_.format,
                         Sha256(fmt::format("{} {}", report.key, n++)).substr(0, 32));
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
        Order(order);
        now.push_back(*same);
        before.erase(same);
      } else if (const auto number = Order(
                     {{"id", id()}, {"issuer", "feed"}, {"order", "task_add"}, {"task", task}})) {
        now.push_back({*number, latitude, longitude});
      }
    }
    for (const Given& old : before) {
      Order({{"id", id()}, {"issuer", "feed"}, {"order", "task_cancel"}, {"task", old.task}});
    }
    if (stop_.count() == 0) memory_.given[report.key] = std::move(now);
  }

  /// The number of its task; none where it is refused.
  std::optional<std::int64_t> Order(const Json& order) {
    client_.Send(order.dump());
    std::string text;
    while (text.empty() && !client_.gone() && stop_.count() == 0) text = client_.Receive(kPause);
    if (stop_.count() > 0) return {};
    if (text.empty()) throw SystemError("the mission has ended; an order had no answer");
    const Json answer = Json::parse(text);
    if (!answer.contains("taken")) {
      Refuse(answer.contains("refused") ? answer["refused"].get<std::string>()
                                        : answer["error"].get<std::string>());
      return {};
    }
    ++counts.taken;
    return answer["taken"].value("task", std::int64_t{0});
  }

  const FeedSettings& settings_;
  const StopSignals& stop_;
  OrderClient client_;
  Memory memory_;
  std::set<std::string> documents_;  ///< SHA-256 of those that were read
  std::set<std::string> refused_;
};

}  // namespace

DocumentSource::DocumentSource(std::string from, std::vector<std::string> endings,
                               std::string token)
    : from_(std::move(from)), endings_(std::move(endings)), token_(std::move(token)) {
  std::error_code ignored;
  if (from_ != "-" && !IsWebAddress(from_) && !fs::exists(from_, ignored)) {
    throw InputError(fmt::format("{}: no such file or folder", from_));
  }
}

std::vector<std::pair<std::string, std::string>> DocumentSource::Read() const {
  if (from_ == "-") return {{"stdin", ReadOne(std::cin, "stdin")}};
  if (IsWebAddress(from_)) return {{from_, Fetch(from_, token_, kMostBytes)}};
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
