#include "model/road_search.h"

#include <algorithm>
#include <utility>

#include "base/index.h"

namespace muster {
namespace {

constexpr std::size_t kFirstSlots = 64;

}  // namespace

void CostQueue::Sort() {
  if (!buckets_[0].empty()) return;
  const auto first = std::find_if(buckets_.begin(), buckets_.end(),
                                  [](const auto& bucket) { return !bucket.empty(); });
  least_ = std::min_element(first->begin(), first->end())->first;
  for (const Entry& entry : *first) buckets_[BucketOf(entry.first)].push_back(entry);
  first->clear();
}

void CostQueue::Lower(std::uint32_t least) {
  least_ = least;
  for (auto& bucket : std::exchange(buckets_, {})) {
    for (const Entry& entry : bucket) buckets_[BucketOf(entry.first)].push_back(entry);
  }
}

RoadSearch::RoadSearch(const RoadGraph& graph, bool far,
                       std::shared_ptr<std::atomic<std::size_t>> bytes)
    : graph_(graph), far_(far), bytes_(std::move(bytes)) {
  if (far) {
    cost_mm_.assign(graph.n_nodes(), kUnreached);
  } else {
    table_.assign(kFirstSlots, {kUnreached, -1});
  }
  *bytes_ += Bytes();
}

RoadSearch::RoadSearch(const RoadSearch& all, const RoadGraph& graph,
                       std::shared_ptr<std::atomic<std::size_t>> bytes)
    : graph_(graph),
      far_(all.far_),
      bytes_(std::move(bytes)),
      cost_mm_(all.cost_mm_),
      table_(all.table_),
      n_in_table_(all.n_in_table_),
      queue_(all.queue_) {
  *bytes_ += Bytes();
}

bool RoadSearch::StaysWithout(std::span<const Arc> arcs) const {
  // An arc was looked at if the node that it leads to is settled. Where it is as short as what is
  // known of the node that it comes from, that may be because of it.
  return std::none_of(arcs.begin(), arcs.end(), [&](const Arc& arc) {
    const std::uint32_t to_mm = CostOf(arc.to);
    return to_mm != kUnreached && to_mm <= final_mm() &&
           CostOf(arc.from) == std::int64_t{to_mm} + arc.cost_mm;
  });
}

std::size_t RoadSearch::SlotOf(std::int32_t node) const {
  const std::size_t last = table_.size() - 1;
  std::size_t slot = (static_cast<std::uint32_t>(node) * 0x9e3779b1U >> 7) & last;
  while (table_[slot].second >= 0 && table_[slot].second != node) slot = (slot + 1) & last;
  return slot;
}

std::uint32_t RoadSearch::CostOf(std::int32_t node) const {
  return cost_mm_.empty() ? table_[SlotOf(node)].first : cost_mm_[At(node)];
}

/// Twice the slots, or room for all nodes where that takes no more.
void RoadSearch::Widen() {
  *bytes_ -= Bytes();
  const std::vector<Entry> old = std::move(table_);
  const bool all = 4 * old.size() > graph_.n_nodes();
  table_.assign(all ? 0 : 2 * old.size(), {kUnreached, -1});
  if (all) cost_mm_.assign(graph_.n_nodes(), kUnreached);
  for (const Entry& entry : old) {
    if (entry.second < 0) continue;
    if (all) {
      cost_mm_[At(entry.second)] = entry.first;
    } else {
      table_[SlotOf(entry.second)] = entry;
    }
  }
  *bytes_ += Bytes();
}

void RoadSearch::Reach(std::int32_t node, std::int64_t cost_mm) {
  if (cost_mm >= CostOf(node)) return;
  const Entry entry{static_cast<std::uint32_t>(cost_mm), node};
  if (cost_mm_.empty()) {
    Entry& slot = table_[SlotOf(node)];
    const bool is_new = slot.second < 0;
    slot = entry;
    if (is_new && 2 * ++n_in_table_ > table_.size()) Widen();
  } else {
    cost_mm_[At(node)] = entry.first;
  }
  queue_.push(entry);
}

void RoadSearch::SettleNext() {
  const auto [cost_mm, node] = queue_.top();
  queue_.pop();
  if (cost_mm > CostOf(node)) return;
  const std::size_t end = graph_.arcs_of[At(node) + 1];
  for (std::size_t i = graph_.arcs_of[At(node)]; i < end; ++i) {
    Reach(graph_.arcs[i].from, std::int64_t{cost_mm} + graph_.arcs[i].cost_mm);
  }
}

std::uint32_t RoadSearch::Extend(std::int32_t node) {
  while (!queue_.empty() && CostOf(node) > queue_.top().first) SettleNext();
  const std::uint32_t found_mm = CostOf(node);
  if (far_) {
    while (!queue_.empty() && queue_.top().first / 2 < found_mm) SettleNext();
  }
  return found_mm;
}

}  // namespace muster
