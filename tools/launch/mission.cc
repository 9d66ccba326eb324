#include "tools/launch/mission.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>

#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/event_log.h"
#include "lcmtypes/channels.h"
#include "lcmtypes/protocol/run_process.h"
#include "tools/launch/mission_view.h"
#include "tools/launch/recorder.h"

namespace muster::tools {
namespace {

constexpr TimeUs kReadyUs = 30 * kSecondUs;
constexpr TimeUs kStopUs = 5 * kSecondUs;
constexpr TimeUs kHeartbeatUs = kSecondUs;
// lcm-logger does not tell that it has written: its file is looked at.
constexpr TimeUs kLookBehindUs = 300;
constexpr TimeUs kLookUs = 20'000;
constexpr int kLastWords = 5;  // lines

/// One mission from start to end.
class Supervisor {
 public:
  Supervisor(const MissionPlan& plan, Bus* bus, const StopSignals& stop, ProgressPrinter* progress)
      : plan_(plan),
        bus_(bus),
        stop_(stop),
        progress_(progress),
        recorder_({plan.run_id, "recorder", 0}),
        record_(plan.run_id) {}

  MissionResult Run();

 private:
  bool killed() const { return stop_.count() > 1; }
  bool Ended() const;
  /// Sees to the bus, the log and the display once; waits a little when there is nothing to do.
  void Turn();
  /// Turns until `done` holds; false when the time is over or a second signal came first.
  template <class Condition>
  bool TurnUntil(Condition done, TimeUs longest_us);
  void ReadLog(const Now& now);
  void ShowProgress(TimeUs now_us);
  /// Looks for processes that should be there and are not.
  bool LostOne();
  void CheckEndOf(Child* child);
  /// Signals and waits; kills whoever does not end.
  void Stop(std::vector<Child>* children);

  const MissionPlan& plan_;
  Bus* bus_;
  const StopSignals& stop_;
  ProgressPrinter* progress_;

  Recorder recorder_;
  RunRecord record_;
  MissionView logged_;
  std::int64_t heard_tick_ = -1;
  std::unique_ptr<EventLogReader> reader_;
  std::vector<Child> logger_;  // one; before the processes: it goes last
  std::vector<Child> processes_;
  std::vector<std::string> problems_;
  std::vector<Packet> out_;
  TimeUs heartbeat_us_ = 0;
  bool finishing_ = false;
  std::optional<TimeUs> started_us_;
};

bool Supervisor::Ended() const {
  return logged_.end_announced() &&
         std::all_of(processes_.begin(), processes_.end(), [this](const Child& child) {
           return logged_.StateOf(child.spec().name) == ProcessState::kEnded;
         });
}

void Supervisor::ReadLog(const Now& now) {
  if (!reader_) {
    if (!std::filesystem::exists(plan_.log_file)) return;
    reader_ = std::make_unique<EventLogReader>(plan_.log_file, EventLogReader::Tail::kMayGrow);
  }
  while (const std::optional<LogEvent> event = reader_->Next()) {
    record_.Add(event->packet);
    if (recorder_.OnLogged(event->packet, now)) logged_.Add(event->packet);
  }
}

void Supervisor::ShowProgress(TimeUs now_us) {
  if (!started_us_ && logged_.started()) started_us_ = now_us;
  if (!progress_->due(now_us)) return;
  const std::int64_t lag = std::max<std::int64_t>(0, heard_tick_ - logged_.tick());
  progress_->Show(ProgressLine(logged_, lag, now_us - started_us_.value_or(now_us)), now_us);
}

void Supervisor::Turn() {
  Now now = HostNow();
  if (!finishing_ && now.monotonic_us >= heartbeat_us_) {
    heartbeat_us_ = now.monotonic_us + kHeartbeatUs;
    recorder_.ReportStatus(logged_.started() ? ProcessState::kRunning : ProcessState::kReady,
                           logged_.tick(), HostUsage(), now);
  }
  ReadLog(now);
  recorder_.Step(now, &out_);
  for (const Packet& packet : out_) bus_->Publish(packet);
  out_.clear();
  ShowProgress(now.monotonic_us);

  const TimeUs look_us = recorder_.behind() ? kLookBehindUs : kLookUs;
  const TimeUs wait_us = std::clamp<TimeUs>(recorder_.wake_us() - MonotonicUs(), 0, look_us);
  const std::vector<Packet> heard = bus_->Receive(wait_us);
  now = HostNow();
  for (const Packet& packet : heard) {
    recorder_.OnHeard(packet, now);
    if (packet.channel != channel::kClock) continue;
    const auto clock = DecodeValid<clock_t>(packet.bytes);
    if (clock && clock->header.run_id == plan_.run_id) {
      heard_tick_ = std::max(heard_tick_, clock->tick);
    }
  }
}

template <class Condition>
bool Supervisor::TurnUntil(Condition done, TimeUs longest_us) {
  const TimeUs deadline_us = MonotonicUs() + longest_us;
  while (!done()) {
    if (killed() || MonotonicUs() >= deadline_us) return false;
    Turn();
  }
  return true;
}

void Supervisor::CheckEndOf(Child* child) {
  const ChildSpec& spec = child->spec();
  std::string text = fmt::format("{} {}", spec.name, child->Poll()->Text());
  const std::string words = LastLines(spec.output_file, kLastWords);
  text += words.empty() ? fmt::format("; {} is empty", spec.output_file)
                        : fmt::format("; {} ends with:\n{}", spec.output_file, words);
  problems_.push_back(std::move(text));
}

bool Supervisor::LostOne() {
  const std::size_t before = problems_.size();
  for (std::vector<Child>* children : {&processes_, &logger_}) {
    for (Child& child : *children) {
      if (child.Poll()) CheckEndOf(&child);
    }
  }
  return problems_.size() > before;
}

void Supervisor::Stop(std::vector<Child>* children) {
  std::vector<Child*> alive;
  for (Child& child : *children) {
    if (child.Poll()) continue;
    child.Signal(SIGTERM);
    alive.push_back(&child);
  }
  TurnUntil(
      [&] { return std::all_of(alive.begin(), alive.end(), [](Child* c) { return c->Poll(); }); },
      kStopUs);
  for (Child* child : alive) {
    if (child->Poll()) {
      if (!child->Poll()->clean()) CheckEndOf(child);
    } else if (!killed()) {
      problems_.push_back(fmt::format("{} did not end within {} s and was killed",
                                      child->spec().name, kStopUs / kSecondUs));
    }
  }
  children->clear();  // kills whoever is left
}

MissionResult Supervisor::Run() {
  MissionResult result;
  logger_.emplace_back(plan_.logger);
  processes_.reserve(plan_.processes.size());
  for (const ChildSpec& spec : plan_.processes) processes_.emplace_back(spec);

  const TimeUs ready_by_us = MonotonicUs() + kReadyUs;
  bool ready = false;
  while (true) {
    if (stop_.count() > 0) {
      result.end = MissionEnd::kInterrupted;
      break;
    }
    if (LostOne()) break;
    if (Ended()) {
      result.end = MissionEnd::kComplete;
      break;
    }
    if (!ready && MonotonicUs() >= ready_by_us) {
      for (const Child& child : processes_) {
        if (logged_.StateOf(child.spec().name) != ProcessState::kStarting) continue;
        problems_.push_back(fmt::format("no word of {} in the log within {} s", child.spec().name,
                                        kReadyUs / kSecondUs));
      }
      if (!problems_.empty()) break;
      ready = true;
    }
    Turn();
  }

  Stop(&processes_);
  finishing_ = true;
  if (!logger_.front().Poll()) {
    recorder_.Finish(logged_.tick(), HostUsage(), HostNow());
    TurnUntil([this] { return recorder_.finished() || logger_.front().Poll(); }, kSecondUs);
  }
  Stop(&logger_);
  ReadLog(HostNow());
  if (reader_ && reader_->pending_bytes() + reader_->garbage_bytes() > 0) {
    record_.NoteDamage(fmt::format("{}: {} bytes belong to no event", plan_.log_file,
                                   reader_->pending_bytes() + reader_->garbage_bytes()));
  }
  if (progress_->due(kNever)) {
    const TimeUs now_us = MonotonicUs();
    progress_->Show(ProgressLine(logged_, 0, now_us - started_us_.value_or(now_us)), now_us);
  }
  progress_->Break();
  if (!problems_.empty() && result.end == MissionEnd::kComplete) result.end = MissionEnd::kFailed;
  result.problems = std::move(problems_);
  result.record = std::move(record_);
  return result;
}

}  // namespace

MissionResult RunMission(const MissionPlan& plan, Bus* bus, const StopSignals& stop,
                         ProgressPrinter* progress) {
  return Supervisor(plan, bus, stop, progress).Run();
}

}  // namespace muster::tools
