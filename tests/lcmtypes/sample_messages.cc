#include "tests/lcmtypes/sample_messages.h"

#include <cstdint>
#include <limits>
#include <string>

namespace muster {
namespace {

header_t Header(std::int64_t seq) {
  header_t header{};
  header.run_id = -17;
  header.sender = "worker-2";
  header.boot_id = 1;
  header.seq = seq;
  header.sim_us = 30'000'000;
  header.wall_us = 1'700'000'000'000'000;
  return header;
}

agent_t Agent(std::int32_t id) {
  agent_t agent{};
  agent.id = id;
  agent.x_m = 1234.5;
  agent.y_m = -0.25;
  agent.speed_m_s = 16.75;
  agent.range_left_m = 12'000;
  agent.range_full_m = 30'000;
  agent.online_until_us = 10'800'000'000;
  agent.busy_until_us = std::numeric_limits<std::int64_t>::max();
  agent.status = 2;
  agent.action = 7;
  agent.target_id = 3;
  agent.partner_id = -1;
  agent.decision = 4;
  return agent;
}

agent_states_t SampleAgentStates() {
  agent_states_t agents{};
  agents.header = Header(0);
  agents.kind = 1;
  agents.tick = 5;
  agents.applied_decision = -1;
  agents.agents = {Agent(0), Agent(1)};
  agents.n = 2;
  return agents;
}

agent_changes_t SampleAgentChanges() {
  agent_changes_t changes{};
  changes.header = Header(13);
  changes.kind = 1;
  changes.tick = 5;
  changes.applied_decision = -1;
  changes.base_tick = 4;
  changes.first_id = 3;
  changes.last_id = 260;
  changes.agents = {Agent(3), Agent(255)};
  changes.n = 2;
  return changes;
}

clock_t SampleClock() {
  clock_t clock{};
  clock.header = Header(1);
  clock.tick = 9;
  clock.tick_us = 270'000'000;
  clock.limit_us = 10'800'000'000;
  clock.decision = -1;
  clock.required_decision = 0;
  clock.phase = 1;
  return clock;
}

event_t SampleEvent() {
  event_t event{};
  event.header = Header(2);
  event.kind = 14;
  event.at_us = 1;
  event.uav_id = event.worker_id = event.vehicle_id = event.task_id = -1;
  event.charge_id = 2;
  event.fault_id = "f1";
  event.detail = "Gewitter über Tal 3";
  return event;
}

fault_t SampleFault() {
  fault_t fault{};
  fault.header = Header(3);
  fault.fault_id = "f1";
  fault.kind = 5;
  fault.target = "uav";
  fault.at_us = 60'000'000;
  fault.for_us = 120'000'000;
  fault.probability = 0.25;
  return fault;
}

log_status_t SampleLogStatus() {
  log_status_t log{};
  log.header = Header(4);
  for (const char* sender : {"world", "uav"}) {
    log_mark_t mark{};
    mark.sender = sender;
    mark.next_seq = 77;
    log.marks.push_back(mark);
  }
  log.n = 2;
  return log;
}

process_status_t SampleProcessStatus() {
  process_status_t status{};
  status.header = Header(5);
  status.name = "uav";
  status.host = "localhost";
  status.pid = 4711;
  status.state = 2;
  status.tick = -1;
  status.received = 10;
  status.cpu_s = 0.5;
  status.rss_bytes = 1 << 20;
  return status;
}

request_t SampleRequest() {
  request_t request{};
  request.header = Header(6);
  request.channel = "MUSTER_WORLD";
  return request;
}

restore_t SampleRestore() {
  restore_t restore{};
  restore.header = Header(7);
  restore.channel = "MUSTER_WORLD";
  restore.tick = 3;
  restore.data = {0, 255, 1, 2};
  restore.n = 4;
  return restore;
}

answer_t SampleAnswer() {
  answer_t answer{};
  answer.header = Header(12);
  answer.asker = "world";
  answer.asker_boot_id = 2;
  answer.asker_seq = 5;
  answer.channel = "MUSTER_WORLD";
  answer.tick = 3;
  answer.data = {0, 255, 1, 2};
  answer.n = 4;
  return answer;
}

order_t SampleOrder() {
  order_t order{};
  order.header = Header(14);
  order.id = "o1";
  order.issuer = "hotline";
  order.json = "{\"order\": \"task_cancel\", \"task\": 3}";
  return order;
}

orders_t SampleOrders() {
  orders_t orders{};
  orders.header = Header(15);
  orders.tick = 7;
  orders.before = 2;
  orders.taken = {
      {"o1", "hotline", "{\"order\": \"task_cancel\", \"task\": 3}", 3, 0, -1},
      {"o2", "page", "{\"order\": \"agent_leave\", \"agent\": \"worker:1\"}", -1, 1, 1}};
  orders.n_taken = 2;
  orders.refused = {{"o3", "page", "there is no task 9: there are 4"}};
  orders.n_refused = 1;
  return orders;
}

rulings_t SampleRulings() {
  rulings_t rulings{};
  rulings.header = Header(8);
  rulings.tick = 3;
  for (std::int8_t kind = 0; kind < 3; ++kind) {
    ruling_t ruling{};
    ruling.agent_kind = kind;
    ruling.agent_id = kind;
    ruling.kind = kind;
    ruling.at_us = 5;
    rulings.rulings.push_back(ruling);
  }
  rulings.n = 3;
  return rulings;
}

clearances_t SampleClearances() {
  clearances_t clearances{};
  clearances.header = Header(10);
  clearances.decision = 2;
  clearances.tick = 40;
  clearances.clearances = {{0, 2, 0, 30, 1'200'000'000}, {3, 1, 30, 120, 605'000'000}};
  clearances.n = 2;
  return clearances;
}

roads_t SampleRoads() {
  roads_t roads{};
  roads.header = Header(9);
  roads.sha256 = std::string(64, 'b');
  roads.roads = R"({"version": 1})";
  return roads;
}

scenario_t SampleScenario() {
  scenario_t scenario{};
  scenario.header = Header(9);
  scenario.sha256 = std::string(64, 'a');
  scenario.json = R"({"version": 1})";
  return scenario;
}

schedule_t SampleSchedule() {
  schedule_t schedule{};
  schedule.header = Header(10);
  schedule.decision = 2;
  schedule.tick = 40;
  schedule.policy = "hocs-mpq";
  schedule.weight = 12.5;
  schedule.bound = std::numeric_limits<double>::quiet_NaN();
  schedule.candidates = 1000;
  schedule.solve_us = 1500;
  for (std::int8_t kind = 0; kind < 10; ++kind) {
    action_t action{};
    action.kind = kind;
    action.uav_id = kind;
    action.worker_id = action.vehicle_id = action.task_id = action.charge_id = -1;
    action.x_m = 1.5;
    action.weight = 0.693;
    schedule.actions.push_back(action);
  }
  schedule.n = 10;
  return schedule;
}

world_state_t SampleWorldState() {
  world_state_t world{};
  world.header = Header(11);
  world.tick = 3;
  world.done = 1;
  world.task_status = {0, 1, 2, 3};
  world.n_tasks = 4;
  activity_t activity{};
  activity.uav_id = 1;
  activity.partner_id = 2;
  activity.site_id = 3;
  activity.start_us = 10;
  activity.end_us = 20;
  world.activities = {activity, activity};
  world.n_activities = 2;
  return world;
}

proposal_t SampleProposal() {
  proposal_t proposal{};
  proposal.header = Header(12);
  proposal.schedule = SampleSchedule();
  proposal.clearances = {SampleClearances()};
  proposal.n_clearances = 1;
  proposal.events = {SampleEvent(), SampleEvent()};
  proposal.n_events = 2;
  return proposal;
}

}  // namespace

AllMessages SampleMessages() {
  return {SampleAgentChanges(), SampleAgentStates(), SampleAnswer(),        SampleClearances(),
          SampleClock(),        SampleEvent(),       SampleFault(),         SampleLogStatus(),
          SampleOrder(),        SampleOrders(),      SampleProcessStatus(), SampleProposal(),
          SampleRequest(),      SampleRestore(),     SampleRoads(),         SampleRulings(),
          SampleScenario(),     SampleSchedule(),    SampleWorldState()};
}

}  // namespace muster
