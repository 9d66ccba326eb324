#include "tools/launch/order_relay.h"

#include <algorithm>

namespace muster::tools {
namespace {

constexpr TimeUs kAgainUs = 200'000;

}  // namespace

void OrderRelay::Step(const Now& now, recorder::Recorder* speaker) {
  if (gate_ == nullptr) return;
  for (order_t& order : gate_->Take(now.wall_us)) {
    const std::string id = order.id;
    if (open_.empty()) again_us_ = now.monotonic_us + kAgainUs;
    open_[id] = speaker->Publish(std::move(order), now);
  }
  if (open_.empty() || now.monotonic_us < again_us_) return;
  again_us_ = now.monotonic_us + kAgainUs;
  for (const auto& [id, packet] : open_) speaker->SendAgain(packet);
}

void OrderRelay::OnLogged(const orders_t& orders) {
  if (gate_ == nullptr) return;
  for (const taken_order_t& order : orders.taken) open_.erase(order.id);
  for (const refused_order_t& order : orders.refused) open_.erase(order.id);
  gate_->Answer(orders);
}

}  // namespace muster::tools
