#include "tools/record/digest.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "base/sha256.h"
#include "muster/action_t.hpp"

namespace muster::tools {
namespace {

class Bytes {
 public:
  void Text(std::string_view text) { text_ += text; }
  void I8(std::int8_t value) { Integer(static_cast<std::uint8_t>(value), 1); }
  void I32(std::int32_t value) { Integer(static_cast<std::uint32_t>(value), 4); }
  void I64(std::int64_t value) { Integer(static_cast<std::uint64_t>(value), 8); }
  void F64(double value) { Integer(std::bit_cast<std::uint64_t>(value), 8); }
  const std::string& text() const { return text_; }

 private:
  void Integer(std::uint64_t value, int n_bytes) {
    for (int i = 0; i < n_bytes; ++i) text_ += static_cast<char>(value >> (8 * i) & 0xff);
  }

  std::string text_;
};

template <class Message>
auto Ids(const Message& m) {
  return std::tie(m.uav_id, m.worker_id, m.vehicle_id, m.task_id, m.charge_id);
}

template <class Message>
void AddIds(const Message& m, Bytes* bytes) {
  for (const std::int32_t id : {m.uav_id, m.worker_id, m.vehicle_id, m.task_id, m.charge_id}) {
    bytes->I32(id);
  }
}

}  // namespace

std::string Digest(const RunRecord& record) {
  Bytes bytes;
  bytes.Text("muster digest 1\n");

  for (const auto& [index, schedule] : record.schedules()) {
    bytes.Text("D");
    bytes.I32(index);
    std::vector<action_t> actions = schedule.actions;
    std::sort(actions.begin(), actions.end(), [](const action_t& a, const action_t& b) {
      return std::tuple_cat(std::tie(a.kind), Ids(a)) < std::tuple_cat(std::tie(b.kind), Ids(b));
    });
    bytes.I32(static_cast<std::int32_t>(actions.size()));
    for (const action_t& action : actions) {
      bytes.I8(action.kind);
      AddIds(action, &bytes);
      bytes.F64(action.x_m);
      bytes.F64(action.y_m);
      bytes.F64(action.weight);
    }
  }

  const std::size_t n_tasks = record.scenario() ? record.scenario()->n_tasks() : 0;
  std::vector<std::int64_t> done_us(n_tasks, -1);
  const event_t* previous = nullptr;
  for (const event_t& event : record.events()) {
    if (!IsOutcome(static_cast<EventKind>(event.kind))) continue;
    const auto same = [&] {
      return previous->at_us == event.at_us && previous->kind == event.kind &&
             Ids(*previous) == Ids(event);
    };
    if (previous != nullptr && same()) continue;
    previous = &event;
    bytes.Text("E");
    bytes.I64(event.at_us);
    bytes.I8(event.kind);
    AddIds(event, &bytes);
    const auto task = static_cast<std::size_t>(event.task_id);
    if (event.kind == EventKind::kSensingDone && event.task_id >= 0 && task < n_tasks &&
        done_us[task] < 0) {
      done_us[task] = event.at_us;
    }
  }

  for (std::size_t task = 0; task < n_tasks; ++task) {
    bytes.Text("T");
    bytes.I8(record.final_world() ? record.final_world()->task_status[task] : std::int8_t{-1});
    bytes.I64(done_us[task]);
  }
  for (const Track& track : record.tracks()) {
    bytes.Text("U");
    bytes.F64(track.final_range_m());
  }
  return Sha256(bytes.text());
}

}  // namespace muster::tools
