#pragma once

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/units.h"

namespace muster::world {

/// The other processes of a mission, by name, as the world hears them. All times are monotonic.
class Peers {
 public:
  enum class Presence {
    kThere,
    kLost,       ///< the mission goes on without it
    kReturning,  ///< was lost and has spoken again
  };

  /// `is_first`: this is the world's first start, so a process that was never heard is not lost. A
  /// later start does not know which processes the earlier ones have heard.
  Peers(TimeUs lost_after_us, bool is_first) : lost_after_us_(lost_after_us), is_first_(is_first) {}

  void Hear(const std::string& name, TimeUs now_us);
  /// Whether it last said that it is at work on its answer.
  void SetDeciding(const std::string& name, bool deciding) { peers_[name].deciding = deciding; }
  /// The process has named itself twice in one message.
  void Introduce(const std::string& name) { introduced_.insert(name); }
  bool introduced(const std::string& name) const { return introduced_.contains(name); }
  bool heard(const std::string& name) const { return peers_.contains(name); }
  /// Called once a step. A world that was itself held up has heard no process meanwhile.
  void NoteAwake(TimeUs now_us);
  /// Until when it must be noted again to count as awake, with time to spare.
  TimeUs AwakeUntilUs() const { return stepped_us_ + lost_after_us_ / 8; }
  /// The log holds back the mission, so silence says nothing about a process.
  void NoteHeld(TimeUs now_us) { awake_since_us_ = now_us; }
  /// From now on an answer is due.
  void AwaitFrom(TimeUs now_us) { due_since_us_ = now_us; }
  /// How long it has been due while this process was awake and the log did not hold it.
  TimeUs AwaitedUs(TimeUs now_us) const {
    return now_us - std::max(due_since_us_, awake_since_us_);
  }
  /// Lost already; or it owes an answer for the limit and is silent for as long; or owes it for
  /// three times the limit, though heard, and does not say that it is at work on it.
  bool Overdue(const std::string& name, TimeUs now_us) const;

  Presence presence(const std::string& name) const;
  void set_presence(const std::string& name, Presence presence) {
    peers_[name].presence = presence;
  }
  std::vector<std::string> NamesOf(Presence presence) const;

 private:
  struct Peer {
    Presence presence = Presence::kThere;
    TimeUs heard_us = 0;
    bool deciding = false;
  };
  const TimeUs lost_after_us_;
  const bool is_first_;
  std::map<std::string, Peer> peers_;
  std::set<std::string> introduced_;
  TimeUs due_since_us_ = 0, stepped_us_ = 0, awake_since_us_ = 0;
};

}  // namespace muster::world
