#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "base/check.h"
#include "lcmtypes/channels.h"
#include "model/agent.h"
#include "protocol/convert.h"
#include "tools/files/pending_file.h"
#include "tools/log/export.h"
#include "tools/log/mcap_writer.h"
#include "tools/log/message_json.h"
#include "tools/log/mission_stream.h"

namespace muster::tools {
namespace {

using nlohmann::ordered_json;

/// Okabe and Ito's colours, which the colour-blind tell apart.
constexpr std::array<double, 3> kBlue = {0.00, 0.45, 0.70};
constexpr std::array<double, 3> kOrange = {0.90, 0.62, 0.00};
constexpr std::array<double, 3> kGreen = {0.00, 0.62, 0.45};
constexpr std::array<double, 3> kVermilion = {0.84, 0.37, 0.00};
constexpr std::array<double, 3> kGrey = {0.60, 0.60, 0.60};

/// The part of Foxglove's SceneUpdate that is used here.
ordered_json SceneSchema() {
  const auto numbers = [](std::initializer_list<const char*> names) {
    ordered_json properties = ordered_json::object();
    for (const char* name : names) properties[name] = {{"type", "number"}};
    return ordered_json{{"type", "object"}, {"properties", std::move(properties)}};
  };
  const auto time = [](const char* fraction) {
    return ordered_json{
        {"type", "object"},
        {"properties", {{"sec", {{"type", "integer"}}}, {fraction, {{"type", "integer"}}}}}};
  };
  const ordered_json pose = {
      {"type", "object"},
      {"properties",
       {{"position", numbers({"x", "y", "z"})}, {"orientation", numbers({"x", "y", "z", "w"})}}}};
  const ordered_json solid = {{"type", "object"},
                              {"properties",
                               {{"pose", pose},
                                {"size", numbers({"x", "y", "z"})},
                                {"color", numbers({"r", "g", "b", "a"})}}}};
  const ordered_json entity = {{"type", "object"},
                               {"properties",
                                {{"timestamp", time("nsec")},
                                 {"frame_id", {{"type", "string"}}},
                                 {"id", {{"type", "string"}}},
                                 {"lifetime", time("nsec")},
                                 {"frame_locked", {{"type", "boolean"}}},
                                 {"spheres", {{"type", "array"}, {"items", solid}}},
                                 {"cubes", {{"type", "array"}, {"items", solid}}}}}};
  return {{"title", "foxglove.SceneUpdate"},
          {"type", "object"},
          {"properties",
           {{"deletions", {{"type", "array"}, {"items", {{"type", "object"}}}}},
            {"entities", {{"type", "array"}, {"items", entity}}}}}};
}

ordered_json Entity(const std::string& id, const char* shape, double x_m, double y_m, double size_m,
                    const std::array<double, 3>& color, std::int64_t unix_us) {
  const ordered_json solid = {
      {"pose",
       {{"position", {{"x", x_m}, {"y", y_m}, {"z", 0}}},
        {"orientation", {{"x", 0}, {"y", 0}, {"z", 0}, {"w", 1}}}}},
      {"size", {{"x", size_m}, {"y", size_m}, {"z", size_m}}},
      {"color", {{"r", color[0]}, {"g", color[1]}, {"b", color[2]}, {"a", 1}}}};
  ordered_json entity = {
      {"timestamp", {{"sec", unix_us / 1'000'000}, {"nsec", unix_us % 1'000'000 * 1000}}},
      {"frame_id", "map"},
      {"id", id},
      {"lifetime", {{"sec", 0}, {"nsec", 0}}},
      {"frame_locked", false}};
  for (const char* list : {"metadata", "arrows", "cubes", "spheres", "cylinders", "lines",
                           "triangles", "texts", "models"}) {
    entity[list] = ordered_json::array();
  }
  entity[shape].push_back(solid);
  return entity;
}

class Scene {
 public:
  explicit Scene(const Scenario& scenario) : status_(scenario.tasks.size(), -1) {}

  /// What changed by a message; no entities when it shows nothing. `scenario`: with the orders so
  /// far.
  ordered_json Update(const Message& message, const Scenario& scenario, std::int64_t unix_us) {
    ordered_json entities = ordered_json::array();
    if (const auto* m = std::get_if<agent_states_t>(&message)) {
      const auto kind = static_cast<AgentKind>(m->kind);
      const auto n = static_cast<std::int32_t>(scenario.n_agents(kind));
      for (const agent_t& a : m->agents) {
        if (a.id >= n) continue;  // room for one who has not joined
        const bool out = a.status == AgentStatus::kOffline || a.status == AgentStatus::kFailed;
        // An entity stays until it is said again.
        const std::tuple shown(a.x_m, a.y_m, out);
        const auto [known, is_new] = shown_.try_emplace({m->kind, a.id}, shown);
        if (!is_new && known->second == shown) continue;
        known->second = shown;
        entities.push_back(Entity(fmt::format("{}:{}", ToString(kind), a.id), "spheres", a.x_m,
                                  a.y_m, out ? 100 : 250,
                                  out ? kGrey : ByKind(kind, kBlue, kOrange, kGreen), unix_us));
      }
    } else if (const auto* w = std::get_if<world_state_t>(&message)) {
      const std::size_t n = std::min(scenario.n_tasks(), status_.size());
      for (std::size_t x = 0; x < n && x < w->task_status.size(); ++x) {
        if (status_[x] == w->task_status[x]) continue;
        status_[x] = w->task_status[x];
        const Point at = scenario.tasks[x].at;
        entities.push_back(Entity(fmt::format("task:{}", x), "cubes", at.x_m, at.y_m,
                                  status_[x] == TaskStatus::kDone ? 120 : 300,
                                  status_[x] == TaskStatus::kDone ? kGrey : kVermilion, unix_us));
      }
    }
    return {{"deletions", ordered_json::array()}, {"entities", std::move(entities)}};
  }

 private:
  std::vector<std::int8_t> status_;
  std::map<std::pair<int, std::int32_t>, std::tuple<double, double, bool>> shown_;
};

}  // namespace

void ExportMcap(LogSource* source, const std::string& out) {
  if (std::filesystem::exists(out)) {
    throw InputError("command line", "--out", out, "a file that does not exist");
  }
  const MissionHead head = ReadMissionHead(source);
  PendingFile pending(out);
  {
    McapWriter writer(pending.temporary());
    const std::uint16_t scene_channel =
        writer.AddChannel("/scene", "foxglove.SceneUpdate", SceneSchema().dump());
    std::map<std::string, std::uint16_t> channels;
    Scene scene(head.scenario);
    std::int64_t at_us = 0;  // readers want times in order
    ForEachMessage(
        source, head.run_id,
        [&](const Message& message, const Packet& packet, const Scenario& scenario) {
          const header_t& header =
              std::visit([](const auto& m) -> const header_t& { return m.header; }, message);
          at_us = std::max(at_us, header.sim_us);
          const std::int64_t unix_us = head.epoch_us + at_us;
          const auto time_ns = static_cast<std::uint64_t>(unix_us) * 1000;
          // What was said as changes comes as the whole states that they stand for.
          const auto* states = std::get_if<agent_states_t>(&message);
          const std::string name(
              states == nullptr ? packet.channel : ChannelOf(static_cast<AgentKind>(states->kind)));
          auto channel = channels.find(name);
          if (channel == channels.end()) {
            const Channel* row = FindChannel(name);
            MUSTER_CHECK(row != nullptr, "{}", name);
            channel = channels
                          .emplace(name, writer.AddChannel(name, "muster." + std::string(row->type),
                                                           MessageSchema(message).dump()))
                          .first;
          }
          writer.Write(channel->second, time_ns, MessageJson(message).dump());
          const ordered_json update = scene.Update(message, scenario, unix_us);
          if (!update["entities"].empty()) writer.Write(scene_channel, time_ns, update.dump());
        });
    writer.Close();
  }
  pending.Commit();
}

}  // namespace muster::tools
