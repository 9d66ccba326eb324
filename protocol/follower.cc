#include "protocol/follower.h"

#include "base/check.h"
#include "base/sha256.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster {
namespace {

constexpr TimeUs kOrdersPatienceUs = 20'000;
/// A process that refuses so many messages doubts the orders that it has heard.
constexpr int kManyImpossible = 20;

}  // namespace

void Follower::OnMessage(const Message& message, const Packet& packet, const Now& now) {
  if (book_) {
    if (!TakeOrders(message, now)) OnMissionMessage(message, packet, now);
    return;
  }
  const auto* scenario = std::get_if<scenario_t>(&message);
  if (scenario != nullptr && Sha256(scenario->json) != scenario->sha256) return inbox().Reject();
  switch (scenario_reader_.Take(message)) {
    case ScenarioReader::Outcome::kRejected:
      return inbox().Reject();
    case ScenarioReader::Outcome::kWhole:
      book_.emplace(scenario_reader_.scenario());
      scenario_reader_ = {};
      return OnScenario();
    default:
      return;
  }
}

void Follower::OnStep(const Now& now) {
  if (!book_) return Ask(channel::kScenario, 0, now);
  OnMissionStep(now);
}

bool Follower::TakeOrders(const Message& message, const Now& now) {
  if (const auto* orders = std::get_if<orders_t>(&message)) {
    if (!book_->Take(*orders)) inbox().Reject();
    return true;
  }
  if (const auto* answer = std::get_if<answer_t>(&message);
      answer != nullptr && answer->channel == channel::kOrders) {
    if (!Answers(*answer)) return true;
    const auto book = DecodeValid<order_book_t>(answer->data);
    if (!book || book->header.run_id != identity().run_id || !book_->Take(*book, DoubtsOrders())) {
      inbox().Reject();
    } else {
      n_impossible_ = 0;
    }
    return true;
  }
  const auto* request = std::get_if<request_t>(&message);
  if (request == nullptr || request->channel != channel::kOrders) return false;
  if (book_->takes_orders()) {
    Answer(*request, book_->tick(), BookBytes(*book_, identity()), 0, now);
  }
  return true;
}

bool Follower::HasOrders(std::int64_t tick, std::int64_t boot_id, const Now& now) {
  if (book_->complete(tick, boot_id)) {
    // Those of a later tick may still be missing.
    if (tick >= lacked_tick_) lacks_orders_since_us_ = kNever;
    return true;
  }
  if (lacks_orders_since_us_ == kNever) lacks_orders_since_us_ = now.monotonic_us;
  lacked_tick_ = tick;
  // What the world says of this tick comes with its clock; only earlier orders have to be asked
  // for.
  if (now.monotonic_us - lacks_orders_since_us_ > kOrdersPatienceUs) {
    Ask(channel::kOrders, book_->scenario()->rules.TimeOf(tick), now);
  }
  return false;
}

void Follower::Follow(const clock_t& clock) {
  if (clock.phase == ClockPhase::kEnded) set_state(ProcessState::kEnded);
  if (clock.phase == ClockPhase::kRunning && state() == ProcessState::kReady)
    set_state(ProcessState::kRunning);
}

void Follower::Ask(std::string_view name, TimeUs sim_us, const Now& now) {
  if (request_.due_us() == kNever) request_.Start(now.monotonic_us);
  if (!request_.Fire(now.monotonic_us)) return;
  Request(name, sim_us, now);
}

void Follower::AskNoMore(const Now& now) {
  if (DoubtsOrders()) {
    return Ask(channel::kOrders, book_->scenario()->rules.TimeOf(book_->tick()), now);
  }
  request_.Stop();
  ForgetQuestions();
}

bool Follower::DoubtsOrders() const {
  return book_->takes_orders() && n_impossible_ >= kManyImpossible;
}

void Follower::Reject() {
  inbox().Reject();
  ++n_impossible_;
}

}  // namespace muster
