#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <pugixml.hpp>
#include <sstream>
#include <utility>

#include "base/check.h"
#include "base/units.h"
#include "tools/orders/alert_feed.h"
#include "tools/scenario/fields.h"

namespace muster::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostName = 80;

struct Place {
  double latitude = 0, longitude = 0;
};

/// The name without its namespace's prefix.
std::string_view LocalName(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  const std::size_t colon = name.find(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

std::vector<pugi::xml_node> Children(const pugi::xml_node& node, std::string_view name) {
  std::vector<pugi::xml_node> found;
  for (const pugi::xml_node& child : node.children()) {
    if (LocalName(child) == name) found.push_back(child);
  }
  return found;
}

std::vector<std::string> SplitWords(const std::string& text) {
  std::istringstream in(text);
  return {std::istream_iterator<std::string>(in), {}};
}

/// In one line.
std::string Text(const pugi::xml_node& node, std::string_view name) {
  const std::vector<pugi::xml_node> found = Children(node, name);
  return found.empty() ? ""
                       : fmt::format("{}", fmt::join(SplitWords(found.front().text().get()), " "));
}

std::optional<Place> PlaceOf(std::string_view text) {
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos) return {};
  const auto latitude = Degrees(text.substr(0, comma), 90);
  const auto longitude = Degrees(text.substr(comma + 1), 180);
  if (!latitude || !longitude) return {};
  return Place{*latitude, *longitude};
}

/// Of the area inside, counted from the first corner; of the corners where it has no area.
Place Centre(const std::vector<Place>& corners) {
  const Place from = corners.front();
  double twice_area = 0, north = 0, east = 0, mean_north = 0, mean_east = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Place& next = corners[(i + 1) % corners.size()];
    const double y = corners[i].latitude - from.latitude, x = corners[i].longitude - from.longitude;
    const double y2 = next.latitude - from.latitude, x2 = next.longitude - from.longitude;
    const double cross = x * y2 - x2 * y;
    twice_area += cross;
    north += (y + y2) * cross;
    east += (x + x2) * cross;
    mean_north += y / static_cast<double>(corners.size());
    mean_east += x / static_cast<double>(corners.size());
  }
  if (std::abs(twice_area) < 1e-12) return {from.latitude + mean_north, from.longitude + mean_east};
  return {from.latitude + north / (3 * twice_area), from.longitude + east / (3 * twice_area)};
}

/// Severity says 0 to 3, urgency one more or less.
int AlertPriority(const std::string& severity, const std::string& urgency) {
  const int base = severity == "Extreme"  ? 3
                   : severity == "Severe" ? 2
                   : severity == "Minor"  ? 0
                                          : 1;
  const int more = urgency == "Immediate" ? 1 : urgency == "Future" || urgency == "Past" ? -1 : 0;
  return std::clamp(base + more, 0, 3);
}

/// Minutes from the alert on: CAP says "immediately" and "within the next hour".
std::optional<double> DueMinutes(const std::string& urgency) {
  if (urgency == "Immediate") return 30;
  if (urgency == "Expected") return 60;
  return {};
}

class AlertReader {
 public:
  AlertReader(const std::string& file, std::string_view status, const std::optional<Moment>& start)
      : file_(file), status_(status), start_(start) {}

  void Read(const pugi::xml_node& alert, Reports* to) const {
    Report report;
    for (const char* part : {"sender", "identifier", "sent"}) {
      const std::string text = Text(alert, part);
      if (text.empty())
        return to->refused.push_back(fmt::format("{}: an alert has no {}", file_, part));
      report.key += (report.key.empty() ? "" : ",") + text;
    }
    report.sent = Text(alert, "sent");
    const std::string where = fmt::format("{}: alert {}", file_, Text(alert, "identifier"));
    const auto refuse = [&](std::string_view key, const std::string& value,
                            std::string_view expected) {
      to->refused.push_back(
          fmt::format("{}: {} is '{}', expected {}", where, key, value, expected));
    };
    const std::string status = Text(alert, "status"), kind = Text(alert, "msgType");
    if (status != status_) return refuse("status", status, status_);
    if (kind != "Alert" && kind != "Update" && kind != "Cancel") {
      return refuse("msgType", kind, "Alert, Update or Cancel");
    }
    const auto sent = ParseMoment(report.sent);
    if (!sent) return refuse("sent", report.sent, kMomentExpected);
    // UTC, so that text compares as time does.
    report.sent = MomentText(sent->unix_us, 0);
    if (kind != "Alert") report.replaces = SplitWords(Text(alert, "references"));
    if (kind != "Cancel") {
      if (!ReadInfos(alert, *sent, refuse, &report)) return;
    }
    to->reports.push_back(std::move(report));
  }

 private:
  template <class Refuse>
  bool ReadInfos(const pugi::xml_node& alert, const Moment& sent, const Refuse& refuse,
                 Report* report) const {
    const std::vector<pugi::xml_node> infos = Children(alert, "info");
    for (const pugi::xml_node& info : infos) {
      // The others say the same again.
      if (Text(info, "language") != Text(infos.front(), "language")) continue;
      Json task = TaskOf(alert, info, sent);
      for (const pugi::xml_node& area : Children(info, "area")) {
        std::vector<Place> places;
        for (const pugi::xml_node& circle : Children(area, "circle")) {
          const std::vector<std::string> words = SplitWords(circle.text().get());
          const auto place = words.size() == 2 ? PlaceOf(words[0]) : std::nullopt;
          if (!place) return refuse("circle", circle.text().get(), "LAT,LON RADIUS"), false;
          places.push_back(*place);
        }
        for (const pugi::xml_node& polygon : Children(area, "polygon")) {
          std::vector<Place> corners;
          for (const std::string& word : SplitWords(polygon.text().get())) {
            const auto place = PlaceOf(word);
            if (!place) return refuse("polygon", word, "LAT,LON"), false;
            corners.push_back(*place);
          }
          if (corners.size() < 4) {
            return refuse("polygon", polygon.text().get(), "four places or more"), false;
          }
          corners.pop_back();  // the first again
          places.push_back(Centre(corners));
        }
        for (const Place& place : places) {
          task["latitude_deg"] = std::round(place.latitude * 1e7) / 1e7;
          task["longitude_deg"] = std::round(place.longitude * 1e7) / 1e7;
          report->tasks.push_back(task);
        }
      }
    }
    if (report->tasks.empty()) return refuse("area", "", "a circle or a polygon"), false;
    return true;
  }

  Json TaskOf(const pugi::xml_node& alert, const pugi::xml_node& info, const Moment& sent) const {
    const std::string urgency = Text(info, "urgency");
    Json task;
    task["priority"] = AlertPriority(Text(info, "severity"), urgency);
    std::string name = Text(info, "headline");
    if (name.empty()) name = Text(info, "event");
    if (name.size() > kMostName) {
      std::size_t end = kMostName;
      while ((static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;  // UTF-8
      name.resize(end);
    }
    if (!name.empty()) task["name"] = name;
    task["external_id"] = Text(alert, "identifier");
    const std::string sender = Text(info, "senderName");
    task["source"] = sender.empty() ? Text(alert, "sender") : sender;
    const auto due = DueMinutes(urgency);
    if (!start_) {
      if (due) task["due_in_min"] = *due;
      return task;
    }
    const auto minutes = [&](const Moment& moment) {
      return static_cast<double>(moment.unix_us - start_->unix_us) / static_cast<double>(kMinuteUs);
    };
    const auto expires = ParseMoment(Text(info, "expires"));
    if (expires) task["expires_min"] = std::max(0.0, minutes(*expires));
    if (due) {
      double until = minutes(sent) + *due;
      if (expires) until = std::min(until, minutes(*expires));
      task["due_min"] = std::max(0.0, until);
    }
    return task;
  }

  const std::string file_, status_;
  const std::optional<Moment> start_;
};

}  // namespace

Reports ReadCap(std::string_view xml, const std::string& file, std::string_view status,
                const std::optional<Moment>& start) {
  pugi::xml_document document;
  // Document types, and with them entities of strangers, are skipped, not read.
  const pugi::xml_parse_result result = document.load_buffer(xml.data(), xml.size());
  if (!result) {
    throw InputError(
        fmt::format("{}: no XML: {} at byte {}", file, result.description(), result.offset));
  }
  const AlertReader reader(file, status, start);
  Reports reports;
  std::size_t alerts = 0;
  struct Walker : pugi::xml_tree_walker {
    std::function<void(const pugi::xml_node&)> take;
    bool for_each(pugi::xml_node& node) override {
      if (LocalName(node) == "alert") take(node);
      return true;
    }
  } walker;
  walker.take = [&](const pugi::xml_node& alert) {
    ++alerts;
    reader.Read(alert, &reports);
  };
  document.traverse(walker);
  if (alerts == 0)
    throw InputError(fmt::format("{}: no <alert> in it; expected CAP 1.1 or 1.2", file));
  return reports;
}

}  // namespace muster::tools
