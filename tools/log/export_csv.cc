#include <fmt/format.h>

#include <map>
#include <type_traits>

#include "model/agent.h"
#include "tools/files/new_folder.h"
#include "tools/log/export.h"
#include "tools/log/mission_stream.h"

namespace muster::tools {
namespace {

/// RFC 4180: quoted where it must be.
std::string Quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

}  // namespace

void ExportCsv(LogSource* source, const std::string& out) {
  const MissionHead head = ReadMissionHead(source);
  NewFolder folder(out);
  auto& agents = folder.Add("agents.csv");
  auto& decisions = folder.Add("decisions.csv");
  auto& actions = folder.Add("actions.csv");
  auto& events = folder.Add("events.csv");
  auto& tasks = folder.Add("tasks.csv");
  auto& processes = folder.Add("processes.csv");
  agents.Write(
      "tick,sim_s,class,id,x_m,y_m,range_left_m,status,action,target,partner,decision\r\n");
  decisions.Write("decision,tick,sim_s,policy,weight,bound,candidates,solve_s,actions\r\n");
  actions.Write("decision,kind,symbol,uav,worker,vehicle,task,charge,x_m,y_m,weight\r\n");
  events.Write("sim_s,kind,uav,worker,vehicle,task,charge,fault,detail\r\n");
  tasks.Write("tick,sim_s,task,status\r\n");
  processes.Write(
      "sim_s,wall_us,name,start,state,received,lost,rejected,resent,cpu_s,rss_bytes\r\n");
  std::vector<std::int8_t> status(head.scenario.tasks.size(), -1);
  ForEachMessage(source, head.run_id, [&](const Message& message, const Packet&) {
    if (const auto* m = std::get_if<agent_states_t>(&message)) {
      for (const agent_t& a : m->agents) {
        agents.Write(fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\r\n", m->tick,
                                 ToSeconds(m->header.sim_us), ToString<AgentKind>(m->kind), a.id,
                                 a.x_m, a.y_m, a.range_left_m, ToString<AgentStatus>(a.status),
                                 a.action, a.target_id, a.partner_id, a.decision));
      }
    } else if (const auto* s = std::get_if<schedule_t>(&message)) {
      decisions.Write(fmt::format("{},{},{},{},{},{},{},{},{}\r\n", s->decision, s->tick,
                                  ToSeconds(s->header.sim_us), Quoted(s->policy), s->weight,
                                  s->bound == s->bound ? fmt::format("{}", s->bound) : "",
                                  s->candidates, ToSeconds(s->solve_us), s->actions.size()));
      for (const action_t& a : s->actions) {
        actions.Write(fmt::format("{},{},{},{},{},{},{},{},{},{},{}\r\n", s->decision, a.kind,
                                  ToString<ActionKind>(a.kind), a.uav_id, a.worker_id, a.vehicle_id,
                                  a.task_id, a.charge_id, a.x_m, a.y_m, a.weight));
      }
    } else if (const auto* e = std::get_if<event_t>(&message)) {
      events.Write(fmt::format("{},{},{},{},{},{},{},{},{}\r\n", ToSeconds(e->at_us),
                               ToString<EventKind>(e->kind), e->uav_id, e->worker_id, e->vehicle_id,
                               e->task_id, e->charge_id, Quoted(e->fault_id), Quoted(e->detail)));
    } else if (const auto* w = std::get_if<world_state_t>(&message)) {
      for (std::size_t x = 0; x < status.size() && x < w->task_status.size(); ++x) {
        if (status[x] == w->task_status[x]) continue;
        status[x] = w->task_status[x];
        tasks.Write(fmt::format("{},{},{},{}\r\n", w->tick, ToSeconds(w->header.sim_us), x,
                                ToString<TaskStatus>(status[x])));
      }
    } else if (const auto* p = std::get_if<process_status_t>(&message)) {
      processes.Write(fmt::format("{},{},{},{},{},{},{},{},{},{},{}\r\n",
                                  ToSeconds(p->header.sim_us), p->header.wall_us, Quoted(p->name),
                                  p->header.boot_id, p->state, p->received, p->lost, p->rejected,
                                  p->resent, p->cpu_s, p->rss_bytes));
    }
  });
  folder.Commit();
}

}  // namespace muster::tools
