#include "tools/replay/player.h"

#include <algorithm>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"

namespace muster::tools {
namespace {

constexpr double kSlowest = 1.0 / 64;
constexpr double kFastest = 65536;

}  // namespace

Player::Player(MessageSource* source, PlayerOptions options)
    : source_(source),
      options_(std::move(options)),
      rate_(options_.rate),
      paused_(options_.paused),
      anchor_position_us_(options_.start_offset_us) {
  Fetch();
}

void Player::Fetch() {
  while (auto message = source_->Next()) {
    if (message->header) log_us_ = std::max(log_us_, message->header->sim_us);
    const std::string& channel = message->packet.channel;
    if (log_us_ < options_.start_offset_us && channel != channel::kScenario &&
        channel != channel::kRoads) {
      continue;
    }
    next_ = Due{std::move(*message), std::max(log_us_, options_.start_offset_us)};
    return;
  }
  next_.reset();
}

void Player::Anchor(TimeUs position_us, TimeUs now_us) {
  anchor_position_us_ = position_us;
  anchor_now_us_ = now_us;
}

TimeUs Player::position_us(TimeUs now_us) const {
  if (!anchor_now_us_ || paused_) return anchor_position_us_;
  if (rate_ == 0) return next_ ? next_->at_us : anchor_position_us_;
  const double elapsed = static_cast<double>(now_us - *anchor_now_us_) * rate_;
  return anchor_position_us_ + static_cast<TimeUs>(elapsed);
}

TimeUs Player::ToNextUs(TimeUs now_us) const {
  return next_ ? std::max<TimeUs>(0, next_->at_us - position_us(now_us)) : 0;
}

void Player::Press(Key key, TimeUs now_us) {
  Anchor(position_us(now_us), now_us);
  switch (key) {
    case Key::kPause:
      paused_ = !paused_;
      break;
    case Key::kNextDecision:
      to_decision_ = true;
      break;
    case Key::kFaster:
      rate_ = rate_ == 0 ? 0 : rate_ >= kFastest ? 0 : rate_ * 2;
      break;
    case Key::kSlower:
      rate_ = rate_ == 0 ? kFastest : std::max(kSlowest, rate_ / 2);
      break;
  }
}

void Player::Restart() {
  source_->Rewind();
  next_.reset();
  log_us_ = 0;
  decision_ = -1;
  Fetch();
}

std::vector<Packet> Player::Step(TimeUs now_us) {
  if (!anchor_now_us_) Anchor(anchor_position_us_, now_us);
  std::vector<Packet> packets;
  full_ = false;
  while (next_ && (to_decision_ || (!paused_ && next_->at_us <= position_us(now_us)))) {
    if (packets.size() == kBatch) {
      full_ = true;
      return packets;
    }
    const bool is_decision = next_->message.packet.channel == channel::kSchedule;
    if (is_decision) {
      const auto schedule = Decode<schedule_t>(next_->message.packet.bytes);
      if (schedule) decision_ = schedule->decision;
    }
    if (to_decision_) Anchor(next_->at_us, now_us);
    if (is_decision) to_decision_ = false;
    const TimeUs at = next_->at_us;
    if (Plays(next_->message.packet.channel)) {
      packets.push_back(WithTag(std::move(next_->message.packet), next_->message.tag));
      ++played_;
    }
    Fetch();
    if (!next_) {
      Anchor(at, now_us);
      to_decision_ = false;
    }
  }
  if (!next_) {
    if (options_.loop) {
      Restart();
      Anchor(options_.start_offset_us, now_us);
      ended_ = !next_;
    } else {
      ended_ = true;
    }
  }
  return packets;
}

TimeUs Player::WakeUs(TimeUs now_us) const {
  if (!next_) return kNever;
  if (full_ || to_decision_) return now_us + kBatchPauseUs;
  if (!anchor_now_us_) return now_us;
  if (paused_) return kNever;
  if (rate_ == 0) return now_us;
  const double wait = static_cast<double>(next_->at_us - anchor_position_us_) / rate_;
  return std::max(now_us, *anchor_now_us_ + static_cast<TimeUs>(std::min(wait, 9e15)) + 1);
}

}  // namespace muster::tools
