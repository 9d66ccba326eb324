#include "protocol/order_book.h"

#include <algorithm>
#include <utility>

#include "base/check.h"
#include "lcmtypes/bus/codec.h"

namespace muster {
namespace {

std::int64_t SizeOf(const orders_t& orders) {
  return static_cast<std::int64_t>(orders.taken.size() + orders.refused.size());
}

/// Which start of the world said it does not matter.
bool SayTheSame(const orders_t& a, const orders_t& b) {
  const auto same_taken = [](const taken_order_t& x, const taken_order_t& y) {
    return x.id == y.id && x.json == y.json && x.task_id == y.task_id && x.agent_id == y.agent_id;
  };
  const auto same_refused = [](const refused_order_t& x, const refused_order_t& y) {
    return x.id == y.id;
  };
  return std::equal(a.taken.begin(), a.taken.end(), b.taken.begin(), b.taken.end(), same_taken) &&
         std::equal(a.refused.begin(), a.refused.end(), b.refused.begin(), b.refused.end(),
                    same_refused);
}

}  // namespace

OrderBook::OrderBook(const Scenario& scenario)
    : takes_orders_(scenario.takes_orders()),
      base_(takes_orders_ ? std::optional(scenario) : std::nullopt),
      scenario_(std::make_shared<Scenario>(scenario)),
      view_(scenario_) {}

bool OrderBook::Take(const orders_t& orders) {
  if (!takes_orders_ || orders.tick > scenario_->rules.last_tick()) return false;
  const auto [known, is_new] = said_.try_emplace(orders.tick, orders);
  if (is_new && orders.tick <= tick_) {
    // Who told this process of so many ticks at once has left out those without orders.
    if (SizeOf(orders) == 0) return true;
    GoBack(orders.tick - 1);
  } else if (!is_new) {
    if (known->second.header.boot_id > orders.header.boot_id) return true;
    const bool same = SayTheSame(known->second, orders);
    known->second = orders;
    if (!same && orders.tick <= tick_) GoBack(orders.tick - 1);
  }
  return GoOn();
}

bool OrderBook::Take(const order_book_t& book, bool anyhow) {
  if (!takes_orders_ || book.tick > scenario_->rules.last_tick()) return false;
  if (book.tick < tick_ && !anyhow) return true;
  GoBack(-1);
  said_.erase(said_.begin(), said_.upper_bound(book.tick));
  bool possible = true;
  for (const orders_t& orders : book.ticks) {
    said_.emplace(orders.tick, orders);
    possible = possible && Read(orders);
  }
  if (!possible) {
    said_.clear();
    GoBack(-1);
    return false;
  }
  tick_ = book.tick;
  return GoOn();
}

void OrderBook::GoBack(std::int64_t tick) {
  *scenario_ = *base_;
  taken_.clear();
  ids_.clear();
  n_ = 0;
  ++version_;
  tick_ = -1;
  for (const auto& [at, orders] : said_) {
    if (at > tick || !Read(orders)) break;
    tick_ = at;
  }
}

bool OrderBook::GoOn() {
  for (auto next = said_.upper_bound(tick_); next != said_.end() && next->second.before == n_;
       ++next) {
    if (!Read(next->second)) {
      said_.erase(next);
      GoBack(tick_);
      return false;
    }
    tick_ = next->first;
  }
  return true;
}

bool OrderBook::Read(const orders_t& orders) {
  if (SizeOf(orders) == 0) return true;
  std::vector<TakenOrder> taken;
  for (const taken_order_t& wire : orders.taken) {
    try {
      Order order = ParseOrder(wire.json, "order");
      order.id = wire.id;
      order.issuer = wire.issuer;
      taken.push_back(TakeInto(scenario_.get(), order, scenario_->rules.TimeOf(orders.tick)));
    } catch (const InputError&) {
      return false;
    }
    if (taken.back().task_id != wire.task_id || taken.back().agent_id != wire.agent_id) {
      return false;
    }
  }
  for (const taken_order_t& order : orders.taken) ids_.insert(order.id);
  for (const refused_order_t& order : orders.refused) ids_.insert(order.id);
  taken_[orders.tick] = std::move(taken);
  n_ += SizeOf(orders);
  ++version_;
  return true;
}

bool OrderBook::complete(std::int64_t tick, std::int64_t boot_id) const {
  if (!complete(tick)) return false;
  const auto said = said_.find(tick);
  return said == said_.end() || said->second.header.boot_id >= boot_id;
}

orders_t OrderBook::SaidAt(std::int64_t tick) const {
  if (const auto said = said_.find(tick); said != said_.end()) return said->second;
  orders_t orders{};
  orders.tick = tick;
  for (auto at = said_.begin(); at != said_.end() && at->first < tick; ++at) {
    orders.before += SizeOf(at->second);
  }
  return orders;
}

std::span<const TakenOrder> OrderBook::TakenAt(std::int64_t tick) const {
  const auto taken = taken_.find(tick);
  if (taken == taken_.end()) return {};
  return taken->second;
}

OrderBook OrderBook::UpTo(std::int64_t tick) const {
  OrderBook book(takes_orders_ ? *base_ : *scenario_);
  for (auto at = said_.begin(); at != said_.end() && at->first <= std::min(tick, tick_); ++at) {
    book.said_.insert(*at);
    book.Read(at->second);
  }
  book.tick_ = std::min(tick, tick_);
  return book;
}

order_book_t OrderBook::ToWire() const {
  order_book_t book{};
  book.tick = tick_;
  for (const auto& [tick, orders] : said_) {
    if (tick <= tick_ && SizeOf(orders) > 0) book.ticks.push_back(orders);
  }
  book.n = static_cast<std::int32_t>(book.ticks.size());
  return book;
}

std::vector<std::uint8_t> BookBytes(const OrderBook& book, const Identity& sender) {
  order_book_t wire = book.ToWire();
  wire.header.run_id = sender.run_id;
  wire.header.sender = sender.name;
  wire.header.boot_id = sender.boot_id;
  return Encode(wire);
}

taken_order_t ToWire(const TakenOrder& taken, std::string json) {
  taken_order_t wire{};
  wire.id = taken.order.id;
  wire.issuer = taken.order.issuer;
  wire.json = std::move(json);
  wire.task_id = taken.task_id;
  wire.agent_kind = NumberOf(taken.order.agent_kind);
  wire.agent_id = taken.agent_id;
  return wire;
}

}  // namespace muster
