#include "tools/live/mission_cap.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <pugixml.hpp>
#include <sstream>

#include "tools/map/local_frame.h"

namespace muster::tools {
namespace {

constexpr const char* kCap = "urn:oasis:names:tc:emergency:cap:1.2";
constexpr const char* kAtom = "http://www.w3.org/2005/Atom";
constexpr const char* kSender = "muster";
constexpr const char* kSeverity[] = {"Minor", "Moderate", "Severe", "Extreme"};  // by priority

void Add(pugi::xml_node* to, const char* name, const std::string& text) {
  to->append_child(name).text().set(text.c_str());
}

class Alerts {
 public:
  Alerts(const Scenario& scenario, std::string run)
      : scenario_(scenario), run_(std::move(run)), frame_(*scenario.origin) {
    // An identifier has no spaces and commas, as references are parted by them.
    for (char& c : run_) {
      if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '-') c = '_';
    }
    for (const auto* agents : {&scenario.uavs, &scenario.workers, &scenario.vehicles}) {
      is_real_ |= std::any_of(agents->begin(), agents->end(),
                              [](const AgentSpec& agent) { return agent.measured; });
    }
  }

  const std::string& run() const { return run_; }
  std::string When(TimeUs t) const {
    std::string text = MomentText(scenario_.start->unix_us + t, scenario_.start->offset_min);
    if (scenario_.start->offset_min == 0) text[text.size() - 6] = '-';  // CAP 1.2: UTC is -00:00
    return text;
  }
  std::string Identifier(std::size_t x) const { return fmt::format("muster.{}.task.{}", run_, x); }
  std::string Title(std::size_t x) const {
    const std::string& name = scenario_.tasks[x].name;
    return name.empty() ? fmt::format("Task {}", x) : name;
  }

  /// Times are of the mission: at `changed_us` it was done, or could no longer be.
  void AddTo(pugi::xml_node* parent, std::size_t x, TaskStatus status, TimeUs changed_us) const {
    const Task& task = scenario_.tasks[x];
    const bool is_over = !IsToDo(status) && status != TaskStatus::kHeld;
    pugi::xml_node alert = parent->append_child("alert");
    alert.append_attribute("xmlns") = kCap;
    Add(&alert, "identifier", Identifier(x) + (is_over ? ".end" : ""));
    Add(&alert, "sender", kSender);
    Add(&alert, "sent", When(is_over ? changed_us : task.reported_us));
    Add(&alert, "status", is_real_ ? "Actual" : "Exercise");
    Add(&alert, "msgType", is_over ? "Cancel" : "Alert");
    Add(&alert, "scope", "Restricted");
    Add(&alert, "restriction", "for those who dispatch");
    if (is_over) {
      Add(&alert, "note", std::string(ToString(status)));
      Add(&alert, "references",
          fmt::format("{},{},{}", kSender, Identifier(x), When(task.reported_us)));
    }
    pugi::xml_node info = alert.append_child("info");
    Add(&info, "category", "Rescue");
    Add(&info, "event", "Sensing task");
    Add(&info, "urgency", task.due_us == kNever ? "Unknown" : "Expected");
    Add(&info, "severity", kSeverity[static_cast<int>(task.priority)]);
    Add(&info, "certainty", "Observed");
    if (task.expires_us != kNever) Add(&info, "expires", When(task.expires_us));
    Add(&info, "senderName", task.source.empty() ? "Muster " + run_ : task.source);
    Add(&info, "headline", Title(x));
    pugi::xml_node area = info.append_child("area");
    Add(&area, "areaDesc", fmt::format("task:{}", x));
    const Origin place = frame_.ToPlace(task.at);
    Add(&area, "circle", fmt::format("{:.7f},{:.7f} 0", place.latitude_deg, place.longitude_deg));
  }

 private:
  const Scenario& scenario_;
  std::string run_;
  const LocalFrame frame_;
  bool is_real_ = false;  ///< an agent at least is no simulated one
};

}  // namespace

std::optional<std::string> MissionCap(const Timeline& timeline, const std::string& run) {
  const Scenario& scenario = timeline.scenario();
  if (!scenario.origin || !scenario.start) return {};
  const Alerts alerts(scenario, run);
  pugi::xml_document document;
  pugi::xml_node feed = document.append_child("feed");
  feed.append_attribute("xmlns") = kAtom;
  Add(&feed, "id", "urn:muster:" + alerts.run());
  Add(&feed, "title", "Tasks of " + run);
  pugi::xml_node author = feed.append_child("author");  // Atom wants one
  Add(&author, "name", "Muster");
  pugi::xml_node updated = feed.append_child("updated");
  TimeUs newest_us = 0;
  for (std::size_t x = 0; x < scenario.n_tasks(); ++x) {
    const auto& changes = timeline.tasks()[x].rows;
    const auto status =
        changes.empty() ? TaskStatus::kOpen : static_cast<TaskStatus>(changes.back().status);
    if (status == TaskStatus::kUnreported) continue;
    const TimeUs changed_us =
        changes.empty() ? scenario.tasks[x].reported_us : changes.back().t_ms * 1000;
    newest_us = std::max(newest_us, changed_us);
    pugi::xml_node entry = feed.append_child("entry");
    Add(&entry, "id", "urn:muster:" + alerts.Identifier(x));
    Add(&entry, "title", alerts.Title(x));
    Add(&entry, "updated", alerts.When(changed_us));
    pugi::xml_node content = entry.append_child("content");
    content.append_attribute("type") = "text/xml";
    alerts.AddTo(&content, x, status, changed_us);
  }
  updated.text().set(alerts.When(newest_us).c_str());
  std::ostringstream text;
  document.save(text, "", pugi::format_raw);
  return text.str();
}

}  // namespace muster::tools
