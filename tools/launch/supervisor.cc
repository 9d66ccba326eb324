#include "tools/launch/supervisor.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "base/check.h"
#include "base/text.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/channels.h"
#include "protocol/fault_kinds.h"
#include "tools/faults/foreign_packets.h"
#include "tools/launch/supervisor_state.h"

namespace muster::tools {
namespace {

constexpr TimeUs kReadyUs = 30 * kSecondUs;
constexpr TimeUs kRoomUs = 60 * kSecondUs;  // for somebody to make room on the disk
constexpr TimeUs kHeartbeatUs = kSecondUs;
// lcm-logger does not tell that it has written: its file is looked at.
constexpr TimeUs kLookBehindUs = 300;
constexpr TimeUs kLookUs = 20'000;
// The mission does not wait until the launcher has read what the recorder has written.
constexpr TimeUs kReadUs = 5'000;
constexpr TimeUs kForeignUs = 2'000;
/// An outage of the network may last that long for each time that a process may be started.
constexpr TimeUs kOutageUs = 10 * kSecondUs;

/// The processes of the mission, and the schedulers that are part of some.
std::vector<std::string> Answering(const MissionPlan& plan) {
  std::vector<std::string> names = plan.processes;
  for (const auto& [process, scheduler] : plan.decides_as) names.push_back(scheduler);
  return names;
}

/// Those that confirm faults on packets; the launcher does so by itself.
std::vector<std::string> Confirming(const MissionPlan& plan) {
  std::vector<std::string> names = Answering(plan);
  if (plan.logger == Logger::kMuster) names.emplace_back(process_name::kRecorder);
  return names;
}

}  // namespace

Supervisor::Supervisor(const MissionPlan& plan, MissionHost* host)
    : plan_(plan),
      host_(host),
      recorder_(LauncherOf(plan), plan.logger == Logger::kLcm ? recorder::Recorder::Marks::kOwn
                                  : plan.has_second_log
                                      ? recorder::Recorder::Marks::kOfTwoRecorders
                                      : recorder::Recorder::Marks::kOfRecorderProcess),
      archive_(plan.scenario, plan.run_id, plan.goes_on),
      stall_watch_(Answering(plan), plan.scenario.rules.tick_us, plan.rate),
      injector_(plan.faults, Confirming(plan)),
      own_faults_(plan.run_id, std::string(LauncherNameWith(plan.logger)), &host->bus(),
                  [this] { return recorder_.log().strangers(); }),
      orders_(plan.orders),
      record_(plan.run_id) {
  const std::string logger(NameOf(plan.logger));
  members_.push_back({logger, plan.StartsOf(logger)});
  for (const std::string& name : plan.processes) members_.push_back({name, plan.StartsOf(name)});
  if (plan.has_second_log) {
    const std::string second = process_name::kSecondRecorder;
    members_.push_back({second, plan.StartsOf(second)});
  }
}

bool Supervisor::Ended() const {
  // A process that has been told to stop repairs nothing, so the log comes first.
  return logged_.end_announced() && injector_.Settled(*this) && !recorder_.behind() &&
         std::all_of(members_.begin() + 1, members_.end(), [this](const Member& member) {
           return member.gone || is_second(member) ||
                  logged_.StateOf(member.name) == ProcessState::kEnded;
         });
}

TimeUs Supervisor::LookUs() const {
  if (plan_.logger == Logger::kMuster) return kReadUs;
  return recorder_.behind() ? kLookBehindUs : kLookUs;
}

void Supervisor::ReadLog(const Now& now) {
  if (plan_.logger == Logger::kMuster) read_us_ = now.monotonic_us + kReadUs;
  while (const auto logged = host_->NextLogged()) {
    const auto& [packet, file] = *logged;
    record_.Add(packet);
    if (plan_.on_logged) plan_.on_logged(packet);
    if (file == host_->log_files() - 1) NoteBack(&members_.front(), now);
    if (!recorder_.OnLogged(packet, now)) continue;
    archive_.Add(packet);
    logged_.Add(packet);
    if (packet.channel == channel::kOrders) {
      if (const auto orders = DecodeValid<orders_t>(packet.bytes)) orders_.OnLogged(*orders);
    }
    if (packet.channel == channel::kDriver) {
      if (const auto said = DecodeValid<event_t>(packet.bytes)) SayOfDriver(*said);
    }
    if (packet.channel == channel::kEvent) {
      if (const auto happened = DecodeValid<event_t>(packet.bytes)) {
        injector_.OnEvent(*happened);
        SayOfProcess(*happened);
      }
    }
    const std::optional<header_t> header = DecodeHeader(packet);
    for (Member& member : members_) {
      if (header && member.back_due && member.name == header->sender &&
          header->boot_id == member.starts - 1) {
        NoteBack(&member, now);
      }
    }
  }
}

void Supervisor::Show(bool at_end) {
  host_->Show(logged_, std::max<std::int64_t>(0, heard_tick_ - logged_.tick()), at_end);
}

void Supervisor::Turn() {
  Now now = host_->now();
  if (!finishing_ && now.monotonic_us >= heartbeat_us_) {
    heartbeat_us_ = now.monotonic_us + kHeartbeatUs;
    recorder_.NoteRefused(host_->bus().refused());
    recorder_.ReportStatus(logged_.started() ? ProcessState::kRunning : ProcessState::kReady,
                           logged_.tick(), host_->usage(), now);
  }
  if (now.monotonic_us >= read_us_) ReadLog(now);
  if (injector_.foreign() && now.monotonic_us >= foreign_us_) {
    foreign_us_ = now.monotonic_us + kForeignUs;
    host_->bus().Publish(ForeignPacket(plan_.run_id, foreign_sent_++));
  }
  orders_.Step(now, &recorder_);
  if (!stopping_) injector_.Step(logged_.started() ? heard_us_ : -1, now.monotonic_us, this);
  recorder_.Step(now, &out_);
  for (const Packet& packet : out_) host_->bus().Publish(packet);
  out_.clear();
  LookAtNetwork();
  Show(false);
  if (!stopping_) {
    if (const auto line = stall_watch_.Line(now.monotonic_us)) Say(*line);
    if (logged_.end_announced()) SeeToEnd(now);
  }
  SayWait(now);

  const TimeUs wait_us =
      std::clamp<TimeUs>(recorder_.wake_us() - host_->now().monotonic_us, 0, LookUs());
  const std::vector<Packet> heard = host_->bus().Receive(wait_us);
  now = host_->now();
  for (const Packet& packet : heard) {
    if (packet.channel == channel::kCopy) {  // what two recorders have to say to each other
      stall_watch_.OnHeard(packet, now.monotonic_us);
      continue;
    }
    recorder_.OnHeard(packet, now);
    const std::optional<header_t> header = DecodeHeader(packet);
    if (!header || header->run_id != plan_.run_id ||
        IsOfEarlierLauncher(header->boot_id, plan_.first_boot)) {
      continue;
    }
    OnMember(packet, now);
    archive_.Add(packet);
    if (packet.channel == channel::kRequest) AnswerFromArchive(packet, now);
    if (packet.channel != channel::kClock) continue;
    const auto clock = DecodeValid<clock_t>(packet.bytes);
    if (clock && clock->header.run_id == plan_.run_id) {
      heard_tick_ = std::max(heard_tick_, clock->tick);
      heard_us_ = std::max(heard_us_, clock->tick_us);
    }
  }
}

void Supervisor::OnMember(const Packet& packet, const Now& now) {
  const std::optional<header_t> header = DecodeHeader(packet);
  if (!header || header->run_id != plan_.run_id) return;
  LookForSuccessor(*header);
  stall_watch_.OnHeard(packet, now.monotonic_us);
  const auto member = std::find_if(members_.begin(), members_.end(),
                                   [&](const Member& m) { return m.name == header->sender; });
  const Namesakes::Known known = {recorder_.log().next_seq(header->sender, header->boot_id),
                                  member == members_.end() ? kNever : member->starts};
  if (const auto line = namesakes_.OnHeard(packet, *header, known)) Say(*line);
  if (packet.channel == channel::kProcess) heard_.Add(packet);
}

void Supervisor::AnswerFromArchive(const Packet& packet, const Now& now) {
  const auto request = DecodeValid<request_t>(packet.bytes);
  if (!request || request->header.run_id != plan_.run_id) return;
  std::vector<answer_t> answers = archive_.Answer(*request, now.monotonic_us);
  const header_t& asker = request->header;
  // When a mission goes on from its log, nobody else can answer.
  const bool is_news = asker.boot_id > plan_.StartsOf(asker.sender);
  if (!answers.empty() && (is_news || plan_.starts.empty()) && !archive_.AnswersAtOnce(*request)) {
    Say(fmt::format(
        "no process answered {} about {}: the launcher answered with what it had heard last",
        asker.sender, request->channel));
  }
  for (answer_t& answer : answers) recorder_.Answer(std::move(answer), now);
}

void Supervisor::SeeToEnd(const Now& now) {
  if (const auto line =
          end_watch_.Line(WaitingAtEnd(members_, logged_, recorder_, *host_), now.monotonic_us))
    Say(*line);
  if (!end_watch_.hopeless(now.monotonic_us)) return;
  for (const recorder::Recorder::Gap& gap : recorder_.gaps()) {
    Say(fmt::format("{} in the log: given up, no process can send them again", TextOf(gap)));
    recorder_.GiveUp(gap);
  }
}

void Supervisor::LookAtNetwork() {
  const TimeUs now_us = host_->now().monotonic_us;
  if (const auto line = refusals_.Line(host_->bus(), now_us)) Say(*line);
  const auto line = network_.Line(host_->bus().Outage(), now_us);
  if (!line) return;
  Say(*line);
  if (network_.reason().empty()) host_->OnNetworkBack();
}

bool Supervisor::NetworkIsGone() {
  const TimeUs lasts_us = network_.lasts_us(host_->now().monotonic_us);
  if (lasts_us < kOutageUs * (1 + plan_.restarts.most)) return false;
  problems_.push_back(fmt::format("the network has been gone for {:.0f} s: {}", ToSeconds(lasts_us),
                                  network_.reason()));
  return true;
}

void Supervisor::Start(Member* member) {
  host_->Start(member->name, member->starts);
  member->back_due = member->starts > 0;
  ++member->starts;
  member->down = false;
}

const Member* Supervisor::ProcessOf(const std::string& name) const {
  const auto whole = std::find_if(plan_.decides_as.begin(), plan_.decides_as.end(),
                                  [&](const auto& own) { return own.second == name; });
  const std::string& process = whole == plan_.decides_as.end() ? name : whole->first;
  const auto found = std::find_if(members_.begin(), members_.end(),
                                  [&](const Member& member) { return member.name == process; });
  return found == members_.end() ? nullptr : &*found;
}

Member* Supervisor::Find(const std::string& name) {
  const auto found = std::find_if(members_.begin(), members_.end(),
                                  [&](const Member& member) { return member.name == name; });
  MUSTER_CHECK(found != members_.end(), "{}", name);
  return &*found;
}

SentPacket Supervisor::Publish(const fault_t& fault) {
  const Now now = host_->now();
  Say(fmt::format("fault {} {}: {} {}", fault.fault_id, fault.for_us == 0 ? "ends" : "begins",
                  ToString<FaultKind>(fault.kind), fault.target));
  if (!RowOf(static_cast<FaultKind>(fault.kind)).damages) {
    if (std::optional<event_t> event = own_faults_.Take(fault)) recorder_.Announce(*event, now);
  }
  return recorder_.Publish(fault, now);
}

void Supervisor::SayOfProcess(const event_t& said) {
  if (said.header.sender != process_name::kWorld) return;
  const std::string who = Printable(said.detail);
  const double at_min = ToMinutes(said.at_us);
  if (said.kind == EventKind::kProcessLost) {
    Say(fmt::format("{} is lost at {:.1f} min: the mission goes on without it", who, at_min));
  } else if (said.kind == EventKind::kProcessBack) {
    Say(fmt::format("{} takes part again at {:.1f} min", who, at_min));
  } else if (said.kind == EventKind::kStateUnknown) {
    Say(fmt::format("what {} did last is not known: its agents stay where they were last heard of",
                    who));
  }
}

void Supervisor::SayOfDriver(const event_t& said) {
  const auto [kind, id] = said.uav_id >= 0      ? std::pair(AgentKind::kUav, said.uav_id)
                          : said.worker_id >= 0 ? std::pair(AgentKind::kWorker, said.worker_id)
                                                : std::pair(AgentKind::kVehicle, said.vehicle_id);
  const auto& agents = plan_.scenario.agents(kind);
  const auto place = static_cast<std::size_t>(std::max(id, 0));
  if (place >= agents.size() || !agents[place].measured) return;
  // Each is said until the world has taken it: the first time counts, of messages each of its own.
  const bool is_message =
      said.kind == EventKind::kDriverSays || said.kind == EventKind::kDriverCalls;
  const auto words = is_message ? std::pair(said.at_us, said.detail) : std::pair(TimeUs{0}, "");
  if (!told_of_drivers_.insert({kind, id, said.kind, words.first, words.second}).second) return;
  const char* const what = said.kind == EventKind::kDriverWaits ? "is not ready, and waits for this"
                           : said.kind == EventKind::kDriverSays  ? "says"
                           : said.kind == EventKind::kDriverCalls ? "calls for help"
                                                                  : "cannot go on";
  Say(fmt::format("{}:{} {}: {}", ToString(kind), id, what, Printable(said.detail)));
}

void Supervisor::Confirm(EventKind kind, const std::string& fault_id) {
  event_t event{};
  event.kind = NumberOf(kind);
  event.at_us = heard_us_;
  event.uav_id = event.worker_id = event.vehicle_id = event.task_id = event.charge_id = -1;
  event.fault_id = fault_id;
  event.detail = process_name::kLauncher;
  recorder_.Announce(std::move(event), host_->now());
}

bool Supervisor::IsRunning(const std::string& name) {
  const Member* member = ProcessOf(name);
  return member != nullptr && !member->down && !has_ended(*member);
}

bool Supervisor::SignalProcess(const std::string& name, int signal) {
  if (!IsRunning(name)) return false;
  host_->Signal(name, signal);
  return true;
}

bool Supervisor::IsGone(const std::string& name) const {
  const Member* member = ProcessOf(name);
  return member != nullptr && member->gone;
}

bool Supervisor::IsStopped(const std::string& name) const {
  const Member* member = ProcessOf(name);
  return member != nullptr && !member->down && host_->IsStopped(name);
}

std::int64_t Supervisor::BootOf(const std::string& name) const {
  const Member* member = ProcessOf(name);
  return member == nullptr ? 0 : member->starts - 1;
}

void Supervisor::Announce(EventKind kind, std::string detail, const Now& now) {
  event_t event{};
  event.kind = NumberOf(kind);
  event.at_us = heard_us_;
  event.uav_id = event.worker_id = event.vehicle_id = event.task_id = event.charge_id = -1;
  event.detail = std::move(detail);
  recorder_.Announce(std::move(event), now);
}

void Supervisor::NoteBack(Member* member, const Now& now) {
  if (!member->back_due) return;
  member->back_due = false;
  if (member->starts - 1 > plan_.StartsOf(member->name)) {
    Say(fmt::format("{} is back", member->name));
  }
  Announce(EventKind::kProcessBack, fmt::format("{}, start {}", member->name, member->starts - 1),
           now);
}

std::string Supervisor::Obituary(const Member& member, const ChildEnd& end) const {
  return fmt::format("{} {}{}", member.name, end.Text(), host_->LastWords(member.name));
}

bool Supervisor::OnEnd(Member* member, const Now& now) {
  const ChildEnd end = *host_->EndOf(member->name);
  const std::string& name = member->name;
  const bool planned = injector_.OnDeath(name, this) || std::exchange(member->moved, false);
  const std::string no_room = is_logger(*member) && !planned ? host_->NoRoom() : "";
  member->forgiven += planned || !no_room.empty();
  const std::int64_t unplanned = member->starts - member->forgiven;
  if (!planned && no_room.empty() && (unplanned > plan_.restarts.most || end.usage_error())) {
    std::string text = Obituary(*member, end);
    if (member->starts > 1) {
      text += fmt::format("\nit was started again {} times", member->starts - 1);
    }
    if (CanDoWithout(*member) && (is_second(*member) || !end.usage_error())) {
      member->gone = true;
      Say(fmt::format("{}\nthe mission goes on without it", text));
      Announce(EventKind::kProcessLost, fmt::format("{} {}, for good", name, end.Text()), now);
      TellRecorder(*member, now);
      return true;
    }
    problems_.push_back(std::move(text));
    return false;
  }
  // It has not even spoken since it was started again: there is no host to start on.
  if (!planned && member->back_due && !host_->OnHostWithStandby(name).empty()) MoveToStandby(name);
  const std::int64_t doublings = std::clamp<std::int64_t>(unplanned - 1, 0, 20);
  const TimeUs wait_us =
      planned ? plan_.restarts.first_us
              : std::min(plan_.restarts.longest_us, plan_.restarts.first_us << doublings);
  member->down = true;
  member->restart_us = now.monotonic_us + wait_us;
  Say(fmt::format("{} {}; starting it again {}", name, end.Text(),
                  member->held       ? "when its fault ends"
                  : !no_room.empty() ? fmt::format("when there is room: {}", no_room)
                  : planned          ? fmt::format("in {:.1f} s", ToSeconds(wait_us))
                            : fmt::format("in {:.1f} s ({} of {})", ToSeconds(wait_us), unplanned,
                                          plan_.restarts.most)));
  Announce(EventKind::kProcessLost, fmt::format("{} {}", name, end.Text()), now);
  if (name != process_name::kLogger) TellRecorder(*member, now);
  return true;
}

void Supervisor::TellRecorder(const Member& ended, const Now& now) {
  recorder_.OnEnd(ended.name, ended.starts - 1, now);
  const auto own = plan_.decides_as.find(ended.name);
  if (own != plan_.decides_as.end()) recorder_.OnEnd(own->second, ended.starts - 1, now);
}

bool Supervisor::CanDoWithout(const Member& member) const {
  if (is_logger(member) || member.name == process_name::kWorld) return false;
  if (plan_.goes_on || is_second(member)) return true;
  // Of several schedulers one is enough.
  return process_name::IsOneOfSchedulers(member.name) &&
         std::any_of(members_.begin(), members_.end(), [&](const Member& other) {
           return &other != &member && process_name::IsOneOfSchedulers(other.name) && !other.gone;
         });
}

bool Supervisor::KeepAlive() {
  const Now now = host_->now();
  for (Member& member : members_) {
    if (member.gone) continue;
    if (!member.down && has_ended(member) && !OnEnd(&member, now)) return false;
    if (!member.down || member.held || now.monotonic_us < member.restart_us) continue;
    if (!network_.reason().empty()) continue;  // it would find none and end
    if (is_logger(member) && !host_->NoRoom().empty()) {
      if (now.monotonic_us < member.restart_us + kRoomUs) continue;
      problems_.push_back(fmt::format("{} cannot go on: {}, for {} s now", member.name,
                                      host_->NoRoom(), kRoomUs / kSecondUs));
      return false;
    }
    Start(&member);
  }
  return true;
}

void Supervisor::CloseLog() {
  ReadLog(host_->now());
  const std::int64_t files = host_->log_files();
  for (std::int64_t file = 0; file < files; ++file) {
    std::string text = host_->TornTail(file);
    if (text.empty()) continue;
    // A logger that was killed leaves a torn event; all of it is in the next file.
    if (file == files - 1) {
      record_.NoteDamage(std::move(text));
    } else {
      record_.NoteTornTail(std::move(text));
    }
  }
}

MissionResult Supervisor::Run() {
  MissionResult result;
  if (!plan_.starts.empty()) ReadEarlierLog();
  if (plan_.first_boot > 0) EndEarlier();
  for (Member& member : members_) Start(&member);

  const TimeUs ready_by_us = host_->now().monotonic_us + kReadyUs;
  bool ready = false;
  while (true) {
    if (host_->stops_asked() > 0) {
      result.end = MissionEnd::kInterrupted;
      break;
    }
    if (logged_.end_announced()) injector_.EndAll(host_->now().monotonic_us, this);
    if (Ended()) {
      result.end = MissionEnd::kComplete;
      break;
    }
    LeaveBehind(host_->now());
    SeeToHosts(host_->now());
    SeeToSecond(host_->now());
    if (is_succeeded_ || !KeepAlive() || NetworkIsGone()) break;
    if (!ready && host_->now().monotonic_us >= ready_by_us) {
      for (auto member = members_.begin() + 1; member != members_.end(); ++member) {
        if (is_second(*member) || logged_.StateOf(member->name) != ProcessState::kStarting)
          continue;
        problems_.push_back(fmt::format("no word of {} in the log within {} s", member->name,
                                        kReadyUs / kSecondUs));
      }
      if (!problems_.empty()) break;
      ready = true;
    }
    Turn();
  }

  injector_.EndAll(host_->now().monotonic_us, this);
  stopping_ = true;
  Member& logger = members_.front();
  if (result.end == MissionEnd::kComplete && has_ended(logger)) Start(&logger);
  std::vector<Member*> processes, seconds;
  for (auto member = members_.begin() + 1; member != members_.end(); ++member) {
    (is_second(*member) ? seconds : processes).push_back(&*member);
  }
  Stop(processes);
  finishing_ = true;
  if (!has_ended(logger)) {
    recorder_.NoteRefused(host_->bus().refused());
    recorder_.Finish(logged_.tick(), host_->usage(), host_->now());
    TurnUntil([&] { return recorder_.finished() || has_ended(logger); }, kSecondUs);
  }
  Stop(seconds);
  Stop({&logger});
  CloseLog();
  Show(true);
  result.message_bytes = recorder_.log().message_bytes();
  result.repeated_bytes = recorder_.log().double_bytes();
  if (!problems_.empty() && result.end == MissionEnd::kComplete) result.end = MissionEnd::kFailed;
  result.problems = std::move(problems_);
  result.without_effect = injector_.WithoutEffect();
  result.refused = host_->bus().refused();
  result.record = std::move(record_);
  return result;
}

MissionResult Supervise(const MissionPlan& plan, MissionHost* host) {
  return Supervisor(plan, host).Run();
}

}  // namespace muster::tools
