#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "protocol/fault_switch.h"
#include "protocol/outage_watch.h"
#include "protocol/refusal_watch.h"
#include "recorder/archive.h"
#include "recorder/recorder.h"
#include "tools/faults/fault_injector.h"
#include "tools/launch/end_watch.h"
#include "tools/launch/member.h"
#include "tools/launch/mission_view.h"
#include "tools/launch/namesakes.h"
#include "tools/launch/order_relay.h"
#include "tools/launch/stall_watch.h"
#include "tools/launch/supervisor.h"

namespace muster::tools {

/// One mission from start to end: what Supervise() does. Of supervisor*.cc.
class Supervisor : private FaultActions {
 public:
  Supervisor(const MissionPlan& plan, MissionHost* host);

  MissionResult Run();

 private:
  bool killed() const { return host_->stops_asked() > 1; }
  bool has_ended(const Member& member) { return host_->EndOf(member.name).has_value(); }
  bool Ended() const;
  /// Sees to the bus, the log and the display once; waits a little when there is nothing to do.
  void Turn();
  /// Turns until `done` holds; false when the time is over or a second signal came first.
  template <class Condition>
  bool TurnUntil(Condition done, TimeUs longest_us);
  /// Notes the sender of a message of this mission.
  void OnMember(const Packet& packet, const Now& now);
  /// Has the processes of an earlier launcher end, wherever they live on: the log does not have all
  /// that they know.
  void EndEarlier();
  /// Whether the message shows that another launcher has taken this one's place.
  void LookForSuccessor(const header_t& header);
  /// Reports now and then what a mission waits for that has not begun, or has ended.
  void SayWait(const Now& now);
  /// The processes and messages that a mission that has ended still waits for.
  std::string Open() const;
  /// Goes on without the processes that are silent after the mission's end.
  void LeaveBehind(const Now& now);
  /// Moves the processes of hosts from which nothing is heard any more to their standbys.
  void SeeToHosts(const Now& now);
  void MoveToStandby(const std::string& name);
  /// Says that the second log will have a hole when its recorder is silent for long.
  void SeeToSecond(const Now& now);
  /// Whether the mission may go on when that member has ended for good, or never ends.
  bool CanDoWithout(const Member& member) const;
  /// Gives up, after the end, messages that no process can send again.
  void SeeToEnd(const Now& now);
  void LookAtNetwork();
  /// The network has been gone for as long as it may.
  bool NetworkIsGone();
  /// How long at most to wait for packets before it looks at the log again.
  TimeUs LookUs() const;
  void ReadLog(const Now& now);
  /// What was logged before this launcher started. Everybody has ended since.
  void ReadEarlierLog();
  void AnswerFromArchive(const Packet& request, const Now& now);
  void Show(bool at_end);
  bool is_logger(const Member& member) const { return &member == &members_.front(); }
  /// The second recorder: the mission can do without it, and it goes last but for the logger.
  static bool is_second(const Member& member) {
    return member.name == process_name::kSecondRecorder;
  }
  void Start(Member* member);
  /// Looks for members that should be there and are not, and starts again those whose time has
  /// come. False: one has ended for good.
  bool KeepAlive();
  bool OnEnd(Member* member, const Now& now);
  /// That it has ended, and the scheduler that is part of it.
  void TellRecorder(const Member& ended, const Now& now);
  void NoteBack(Member* member, const Now& now);
  /// Publishes an event_t about a process.
  void Announce(EventKind kind, std::string detail, const Now& now);
  /// What the world tells of a process.
  void SayOfProcess(const event_t& said);
  void SayOfDriver(const event_t& said);
  void Say(const std::string& line) {
    if (!reads_earlier_) host_->Say(line);
  }
  /// The process of that name, or that such a scheduler is part of. Null: there is none.
  const Member* ProcessOf(const std::string& name) const;
  Member* Find(const std::string& name);
  SentPacket Publish(const fault_t& fault) override;
  void SendAgain(const SentPacket& packet) override { recorder_.SendAgain(packet); }
  void Confirm(EventKind kind, const std::string& fault_id) override;
  bool SignalProcess(const std::string& name, int signal) override;
  void HoldRestart(const std::string& name) override { Find(name)->held = true; }
  void ReleaseRestart(const std::string& name) override { Find(name)->held = false; }
  void SetDiskFull(bool full) override {
    if (!members_.front().down) host_->SetDiskFull(full);
  }
  bool IsRunning(const std::string& name) override;
  bool IsStopped(const std::string& name) const override;
  bool IsGone(const std::string& name) const override;
  std::int64_t BootOf(const std::string& name) const override;
  std::string Obituary(const Member& member, const ChildEnd& end) const;
  /// Signals and waits; kills processes that do not end.
  void Stop(const std::vector<Member*>& members);
  void CloseLog();

  const MissionPlan& plan_;
  MissionHost* host_;

  recorder::Recorder recorder_;
  /// What drivers have said: agent, event, and of a message its time and words.
  std::set<std::tuple<AgentKind, std::int32_t, std::int8_t, TimeUs, std::string>> told_of_drivers_;
  recorder::Archive archive_;
  StallWatch stall_watch_;
  Patience patience_;
  Namesakes namesakes_;
  FaultInjector injector_;
  FaultSwitch own_faults_;
  OutageWatch network_;
  RefusalWatch refusals_;
  OrderRelay orders_;
  EndWatch end_watch_;
  RunRecord record_;
  MissionView logged_;
  MissionView heard_;  ///< states of processes
  std::int64_t heard_tick_ = -1;
  TimeUs heard_us_ = 0;          ///< mission time
  std::vector<Member> members_;  ///< the logger first: it goes last
  std::vector<std::string> problems_;
  std::vector<Packet> out_;
  std::string stopping_whom_;  ///< the processes that shall end now
  TimeUs end_heard_us_ = kNever;
  TimeUs turned_us_ = 0;
  TimeUs looked_at_hosts_us_ = 0, awake_since_us_ = 0;
  TimeUs read_us_ = 0;  ///< when to read the log again
  TimeUs heartbeat_us_ = 0;
  TimeUs foreign_us_ = 0;
  std::uint64_t foreign_sent_ = 0;
  bool reads_earlier_ = false;
  bool is_second_lost_ = false;
  std::int64_t later_seq_ = -1;  ///< a number of a later launcher's
  bool is_succeeded_ = false;
  bool stopping_ = false;
  bool finishing_ = false;
};

template <class Condition>
bool Supervisor::TurnUntil(Condition done, TimeUs longest_us) {
  const TimeUs deadline_us = host_->now().monotonic_us + longest_us;
  while (!done()) {
    if (killed() || host_->now().monotonic_us >= deadline_us) return false;
    Turn();
  }
  return true;
}

}  // namespace muster::tools
