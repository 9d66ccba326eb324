#include "tools/log/message_json.h"

#include <cmath>
#include <type_traits>
#include <vector>

namespace muster::tools {
namespace {

using nlohmann::ordered_json;

// The fields of each type, once, for values and schemas alike.
template <class V>
void Visit(const header_t& m, V&& v) {
  v("run_id", m.run_id);
  v("sender", m.sender);
  v("boot_id", m.boot_id);
  v("seq", m.seq);
  v("sim_us", m.sim_us);
  v("wall_us", m.wall_us);
}
template <class V>
void Visit(const agent_t& m, V&& v) {
  v("id", m.id);
  v("x_m", m.x_m);
  v("y_m", m.y_m);
  v("speed_m_s", m.speed_m_s);
  v("range_left_m", m.range_left_m);
  v("range_full_m", m.range_full_m);
  v("charge_rate_m_s", m.charge_rate_m_s);
  v("from_x_m", m.from_x_m);
  v("from_y_m", m.from_y_m);
  v("range_at_departure_m", m.range_at_departure_m);
  v("depart_us", m.depart_us);
  v("arrive_us", m.arrive_us);
  v("online_from_us", m.online_from_us);
  v("online_until_us", m.online_until_us);
  v("busy_until_us", m.busy_until_us);
  v("status", m.status);
  v("action", m.action);
  v("target_id", m.target_id);
  v("partner_id", m.partner_id);
  v("decision", m.decision);
}
template <class V>
void Visit(const activity_t& m, V&& v) {
  v("kind", m.kind);
  v("uav_id", m.uav_id);
  v("partner_id", m.partner_id);
  v("site_id", m.site_id);
  v("start_us", m.start_us);
  v("end_us", m.end_us);
}
template <class V>
void Visit(const action_t& m, V&& v) {
  v("kind", m.kind);
  v("uav_id", m.uav_id);
  v("worker_id", m.worker_id);
  v("vehicle_id", m.vehicle_id);
  v("task_id", m.task_id);
  v("charge_id", m.charge_id);
  v("x_m", m.x_m);
  v("y_m", m.y_m);
  v("weight", m.weight);
}
template <class V>
void Visit(const ruling_t& m, V&& v) {
  v("agent_kind", m.agent_kind);
  v("agent_id", m.agent_id);
  v("kind", m.kind);
  v("at_us", m.at_us);
}
template <class V>
void Visit(const log_mark_t& m, V&& v) {
  v("sender", m.sender);
  v("boot_id", m.boot_id);
  v("next_seq", m.next_seq);
}
template <class V>
void Visit(const scenario_t& m, V&& v) {
  v("header", m.header);
  v("sha256", m.sha256);
  v("json", m.json);
}
template <class V>
void Visit(const clock_t& m, V&& v) {
  v("header", m.header);
  v("tick", m.tick);
  v("tick_us", m.tick_us);
  v("limit_us", m.limit_us);
  v("decision", m.decision);
  v("required_decision", m.required_decision);
  v("phase", m.phase);
}
template <class V>
void Visit(const world_state_t& m, V&& v) {
  v("header", m.header);
  v("tick", m.tick);
  v("done", m.done);
  v("task_status", m.task_status);
  v("activities", m.activities);
}
template <class V>
void Visit(const rulings_t& m, V&& v) {
  v("header", m.header);
  v("tick", m.tick);
  v("rulings", m.rulings);
}
template <class V>
void Visit(const agent_states_t& m, V&& v) {
  v("header", m.header);
  v("kind", m.kind);
  v("tick", m.tick);
  v("applied_decision", m.applied_decision);
  v("agents", m.agents);
}
template <class V>
void Visit(const agent_changes_t& m, V&& v) {
  v("header", m.header);
  v("kind", m.kind);
  v("tick", m.tick);
  v("applied_decision", m.applied_decision);
  v("base_tick", m.base_tick);
  v("first_id", m.first_id);
  v("last_id", m.last_id);
  v("agents", m.agents);
}
template <class V>
void Visit(const schedule_t& m, V&& v) {
  v("header", m.header);
  v("decision", m.decision);
  v("tick", m.tick);
  v("policy", m.policy);
  v("weight", m.weight);
  v("bound", m.bound);
  v("candidates", m.candidates);
  v("solve_us", m.solve_us);
  v("actions", m.actions);
}
template <class V>
void Visit(const event_t& m, V&& v) {
  v("header", m.header);
  v("kind", m.kind);
  v("at_us", m.at_us);
  v("uav_id", m.uav_id);
  v("worker_id", m.worker_id);
  v("vehicle_id", m.vehicle_id);
  v("task_id", m.task_id);
  v("charge_id", m.charge_id);
  v("fault_id", m.fault_id);
  v("detail", m.detail);
}
template <class V>
void Visit(const fault_t& m, V&& v) {
  v("header", m.header);
  v("fault_id", m.fault_id);
  v("kind", m.kind);
  v("target", m.target);
  v("at_us", m.at_us);
  v("for_us", m.for_us);
  v("probability", m.probability);
}
template <class V>
void Visit(const process_status_t& m, V&& v) {
  v("header", m.header);
  v("name", m.name);
  v("host", m.host);
  v("pid", m.pid);
  v("state", m.state);
  v("tick", m.tick);
  v("received", m.received);
  v("lost", m.lost);
  v("rejected", m.rejected);
  v("resent", m.resent);
  v("cpu_s", m.cpu_s);
  v("rss_bytes", m.rss_bytes);
}
template <class V>
void Visit(const log_status_t& m, V&& v) {
  v("header", m.header);
  v("marks", m.marks);
}
template <class V>
void Visit(const order_t& m, V&& v) {
  v("header", m.header);
  v("id", m.id);
  v("issuer", m.issuer);
  v("json", m.json);
}
template <class V>
void Visit(const taken_order_t& m, V&& v) {
  v("id", m.id);
  v("issuer", m.issuer);
  v("json", m.json);
  v("task_id", m.task_id);
  v("agent_kind", m.agent_kind);
  v("agent_id", m.agent_id);
}
template <class V>
void Visit(const refused_order_t& m, V&& v) {
  v("id", m.id);
  v("issuer", m.issuer);
  v("reason", m.reason);
}
template <class V>
void Visit(const orders_t& m, V&& v) {
  v("header", m.header);
  v("tick", m.tick);
  v("before", m.before);
  v("taken", m.taken);
  v("refused", m.refused);
}
template <class V>
void Visit(const request_t& m, V&& v) {
  v("header", m.header);
  v("channel", m.channel);
}
template <class V>
void Visit(const restore_t& m, V&& v) {
  v("header", m.header);
  v("channel", m.channel);
  v("tick", m.tick);
}
template <class V>
void Visit(const answer_t& m, V&& v) {
  v("header", m.header);
  v("asker", m.asker);
  v("asker_boot_id", m.asker_boot_id);
  v("asker_seq", m.asker_seq);
  v("channel", m.channel);
  v("tick", m.tick);
}

template <class T>
ordered_json Value(const T& value) {
  if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
    return value;
  } else if constexpr (requires { value.begin(); }) {
    ordered_json array = ordered_json::array();
    for (const auto& item : value) array.push_back(Value(item));
    return array;
  } else {
    ordered_json object = ordered_json::object();
    Visit(value, [&](const char* name, const auto& field) {
      if constexpr (std::is_floating_point_v<std::decay_t<decltype(field)>>) {
        if (!std::isfinite(field)) return;
      }
      object[name] = Value(field);
    });
    return object;
  }
}

template <class T>
struct SchemaOf {
  static ordered_json Get() {
    if constexpr (std::is_integral_v<T>) {
      return {{"type", "integer"}};
    } else if constexpr (std::is_floating_point_v<T>) {
      return {{"type", "number"}};
    } else {
      ordered_json properties = ordered_json::object();
      Visit(T{}, [&](const char* name, const auto& field) {
        properties[name] = SchemaOf<std::decay_t<decltype(field)>>::Get();
      });
      return {{"type", "object"}, {"properties", std::move(properties)}};
    }
  }
};
template <>
struct SchemaOf<std::string> {
  static ordered_json Get() { return {{"type", "string"}}; }
};
template <class T>
struct SchemaOf<std::vector<T>> {
  static ordered_json Get() { return {{"type", "array"}, {"items", SchemaOf<T>::Get()}}; }
};

}  // namespace

ordered_json MessageJson(const Message& message) {
  return std::visit([](const auto& m) { return Value(m); }, message);
}

ordered_json MessageSchema(const Message& type) {
  return std::visit([](const auto& m) { return SchemaOf<std::decay_t<decltype(m)>>::Get(); }, type);
}

}  // namespace muster::tools
