#include "learning/replay.h"

#include <algorithm>

#include "base/index.h"

namespace muster::learning {

using scheduler::learned::AgentView;
using scheduler::learned::kAgentFeatures;
using scheduler::learned::kMaps;
using scheduler::learned::kOptionFeatures;
using scheduler::learned::kOptions;
using scheduler::learned::PlaceOption;
using scheduler::learned::Shape;

namespace {

template <class T>
Tensor TensorOf(const std::vector<T>& values, c10::ScalarType type,
                const std::vector<std::int64_t>& shape) {
  Tensor tensor = torch::empty(shape, type);
  std::copy(values.begin(), values.end(), tensor.data_ptr<T>());
  return tensor;
}

}  // namespace

Seen SeenOf(const std::vector<const Turn*>& turns, const Shape& shape) {
  const auto n = static_cast<std::int64_t>(turns.size());
  const std::int64_t agents = shape.n_agents();
  Seen seen;
  seen.size = n;
  std::vector<std::uint8_t> maps;
  for (const Turn* turn : turns) {
    maps.insert(maps.end(), turn->observation.maps.begin(), turn->observation.maps.end());
  }
  seen.maps = TensorOf(maps, torch::kUInt8, {n, kMaps, shape.rows, shape.columns});
  seen.present = torch::zeros({n, agents});
  seen.available = torch::zeros({n, agents, kOptions}, torch::kBool);
  seen.available.select(2, 0).fill_(true);
  seen.at_km = torch::zeros({n, agents, 2});
  seen.reach_km = torch::zeros({n, agents});
  auto present = seen.present.accessor<float, 2>();
  auto available = seen.available.accessor<bool, 3>();
  auto at = seen.at_km.accessor<float, 3>();
  auto reach = seen.reach_km.accessor<float, 2>();
  for (const AgentKind kind : kAgentKinds) {
    std::vector<std::int64_t> slot, situation, id;
    std::vector<float> own, features;
    for (std::int64_t b = 0; b < n; ++b) {
      for (const AgentView& view : turns[At(b)]->observation.agents[kind]) {
        const std::int64_t place = shape.first(kind) + view.id;
        slot.push_back(b * agents + place);
        situation.push_back(b);
        id.push_back(view.id);
        own.insert(own.end(), view.own.begin(), view.own.end());
        present[b][place] = 1;
        at[b][place][0] = static_cast<float>(view.at.x_m / 1000);
        at[b][place][1] = static_cast<float>(view.at.y_m / 1000);
        reach[b][place] = static_cast<float>(view.reach_m / 1000);
        for (std::size_t k = 0; k < kOptions; ++k) {
          available[b][place][static_cast<std::int64_t>(k)] =
              view.options[k].kind != PlaceOption::Kind::kNone;
          features.insert(features.end(), view.features[k].begin(), view.features[k].end());
        }
      }
    }
    const auto rows = static_cast<std::int64_t>(slot.size());
    seen.rows[static_cast<std::size_t>(kind)] = {
        TensorOf(slot, torch::kInt64, {rows}), TensorOf(situation, torch::kInt64, {rows}),
        TensorOf(id, torch::kInt64, {rows}), TensorOf(own, torch::kFloat32, {rows, kAgentFeatures}),
        TensorOf(features, torch::kFloat32, {rows, kOptions, kOptionFeatures})};
  }
  return seen;
}

Lesson LessonOf(const std::vector<const Episode*>& episodes, const Shape& shape) {
  std::vector<const Turn*> turns;
  std::vector<float> reward, gain, done;
  std::vector<std::int64_t> next;
  for (const Episode* episode : episodes) {
    for (const Turn& turn : episode->turns) {
      const bool last = &turn == &episode->turns.back();
      turns.push_back(&turn);
      reward.push_back(turn.reward);
      gain.push_back(turn.charge_gain);
      done.push_back(last ? 1.0F : 0.0F);
      next.push_back(static_cast<std::int64_t>(turns.size()) - (last ? 1 : 0));
    }
  }
  Lesson lesson;
  lesson.seen = SeenOf(turns, shape);
  const std::int64_t n = lesson.seen.size;
  lesson.happened.reward = TensorOf(reward, torch::kFloat32, {n});
  lesson.happened.charge_gain = TensorOf(gain, torch::kFloat32, {n});
  lesson.happened.done = TensorOf(done, torch::kFloat32, {n});
  lesson.happened.next = TensorOf(next, torch::kInt64, {n});
  lesson.happened.actions = torch::zeros({n, shape.n_agents()}, torch::kInt64);
  auto actions = lesson.happened.actions.accessor<std::int64_t, 2>();
  for (std::int64_t b = 0; b < n; ++b) {
    const Turn& turn = *turns[At(b)];
    for (const AgentKind kind : kAgentKinds) {
      for (std::size_t i = 0; i < turn.choices[kind].size(); ++i) {
        actions[b][shape.first(kind) + turn.observation.agents[kind][i].id] = turn.choices[kind][i];
      }
    }
  }
  return lesson;
}

}  // namespace muster::learning
