#include "tools/live/packet_source.h"

#include <fmt/format.h>
#include <poll.h>

#include <filesystem>
#include <utility>

#include "base/check.h"
#include "base/say.h"
#include "lcmtypes/bus/codec.h"
#include "lcmtypes/bus/lcm_bus.h"
#include "lcmtypes/bus/multicast.h"
#include "lcmtypes/channels.h"
#include "protocol/run_process.h"
#include "tools/files/log_files.h"
#include "tools/files/run_directory.h"

namespace muster::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kAtOnce = 1000;
constexpr std::size_t kBytesAtOnce = 8 << 20;  ///< states of a city's agents are megabytes each
constexpr TimeUs kAskAgainUs = kSecondUs;
constexpr TimeUs kGraceUs = kSecondUs / 2;  // it may come by itself

/// The log files of a run directory as they come and grow.
class FollowedRun : public PacketSource {
 public:
  explicit FollowedRun(const std::string& run) : run_(run) {
    std::error_code ignored;
    is_directory_ = fs::is_directory(run, ignored);
    if (!is_directory_ && !fs::is_regular_file(run, ignored)) {
      throw InputError(fmt::format("{}: no such run directory or log file", run));
    }
  }

  std::vector<Packet> Read(TimeUs wait_us) override {
    std::vector<Packet> packets = ReadOn();
    if (!packets.empty()) return packets;
    poll(nullptr, 0, static_cast<int>(wait_us / 1000));
    return ReadOn();
  }

  bool is_log() const override { return true; }
  std::string name() const override {
    fs::path path = fs::absolute(run_).lexically_normal();
    if (!path.has_filename()) path = path.parent_path();
    if (path.filename() == "mission.lcm") path = path.parent_path();
    return path.filename().string();
  }

 private:
  std::vector<Packet> ReadOn() {
    while (true) {
      const std::string next = is_directory_
                                   ? (fs::path(run_) / "mission.lcm").string() +
                                         (files_.empty() ? "" : fmt::format(".{}", files_.size()))
                                   : run_;
      std::error_code ignored;
      if ((!is_directory_ && !files_.empty()) || !fs::is_regular_file(next, ignored)) break;
      files_.push_back(OpenLog(next, EventLogReader::Tail::kMayGrow));
    }
    std::vector<Packet> packets;
    std::size_t bytes = 0;
    for (const auto& file : files_) {
      while (packets.size() < kAtOnce && bytes < kBytesAtOnce) {
        std::optional<LogEvent> event = file->Next();
        if (!event) break;
        bytes += event->packet.bytes.size();
        packets.push_back(std::move(event->packet));
      }
    }
    return packets;
  }

  std::string run_;
  bool is_directory_ = false;
  std::vector<std::unique_ptr<EventLogReader>> files_;
};

class HeardBus : public PacketSource {
 public:
  explicit HeardBus(const std::string& url) : bus_(url, kMostTagBytes) {}

  std::vector<Packet> Read(TimeUs wait_us) override {
    std::vector<Packet> packets = bus_.Receive(wait_us);
    for (Packet& packet : packets) {
      sealed_ |= !CutTag(&packet).empty();
      if (const auto header = DecodeHeader(packet)) heard_ = header->run_id;
      if (packet.channel == channel::kScenario) known_ = heard_;
    }
    // A process without the key gets no answer.
    if (sealed_) return packets;
    if (const auto question = request_.Due(heard_, heard_ && known_ == heard_, MonotonicUs())) {
      bus_.Publish(*question);
    }
    return packets;
  }

  bool is_log() const override { return false; }
  std::string name() const override { return ""; }

 private:
  LcmBus bus_;
  ScenarioRequest request_;
  std::optional<std::int64_t> heard_, known_;
  bool sealed_ = false;
};

}  // namespace

std::optional<Packet> ScenarioRequest::Due(std::optional<std::int64_t> heard, bool known,
                                           TimeUs now_us) {
  if (!heard || known) return {};
  if (run_id_ != heard) {
    run_id_ = heard;
    packet_.reset();
    due_us_ = now_us + kGraceUs;
  }
  if (now_us < due_us_) return {};
  due_us_ = now_us + kAskAgainUs;
  if (!packet_) {
    request_t request{};
    request.header.run_id = *heard;
    request.header.sender = "viewer";
    request.header.wall_us = HostNow().wall_us;
    request.header.boot_id = request.header.wall_us;  // viewers do not know of each other
    request.channel = channel::kScenario;
    packet_ = Packet{std::string(channel::kRequest), Encode(request)};
  }
  return packet_;
}

std::unique_ptr<PacketSource> OpenPacketSource(const std::string& run_or_url) {
  if (run_or_url.find("://") != std::string::npos) return std::make_unique<HeardBus>(run_or_url);
  return std::make_unique<FollowedRun>(run_or_url);
}

std::string MissionHere() {
  const NewestRun newest = FindNewestRun("runs");
  if (newest.goes_on) {
    Say("{}\n", newest.path);
    return newest.path;
  }
  std::string url = DefaultUrl();
  if (!newest.path.empty()) {
    Say("no run goes on here: listening on {} (the newest run is {})\n", url, newest.path);
  }
  return url;
}

}  // namespace muster::tools
