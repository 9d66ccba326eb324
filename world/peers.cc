#include "world/peers.h"

namespace muster::world {
namespace {

/// So many limits without an answer make a process lost though it is heard: it may be deaf.
constexpr int kDeaf = 3;

}  // namespace

void Peers::Hear(const std::string& name, TimeUs now_us) {
  Peer& peer = peers_[name];
  peer.heard_us = now_us;
  if (peer.presence == Presence::kLost) peer.presence = Presence::kReturning;
}

void Peers::NoteAwake(TimeUs now_us) {
  if (now_us - stepped_us_ > lost_after_us_ / 4) awake_since_us_ = now_us;
  stepped_us_ = now_us;
}

bool Peers::Overdue(const std::string& name, TimeUs now_us) const {
  const auto peer = peers_.find(name);
  if (peer != peers_.end() && peer->second.presence == Presence::kLost) return true;
  if (peer == peers_.end() && is_first_) return false;
  const TimeUs awaited_us = AwaitedUs(now_us);
  // A process that was not asked had no need to answer.
  const bool silent = peer == peers_.end() || now_us - peer->second.heard_us >= lost_after_us_;
  if (!silent && peer->second.deciding) return false;
  return awaited_us >= (silent ? 1 : kDeaf) * lost_after_us_;
}

Peers::Presence Peers::presence(const std::string& name) const {
  const auto peer = peers_.find(name);
  return peer == peers_.end() ? Presence::kThere : peer->second.presence;
}

std::vector<std::string> Peers::NamesOf(Presence presence) const {
  std::vector<std::string> names;
  for (const auto& [name, peer] : peers_) {
    if (peer.presence == presence) names.push_back(name);
  }
  return names;
}

}  // namespace muster::world
