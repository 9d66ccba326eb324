#include "tools/live/live_feed.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <utility>

#include "base/check.h"
#include "lcmtypes/channels.h"
#include "tools/host/quiet_thread.h"
#include "tools/live/mission_cap.h"
#include "tools/live/mission_geojson.h"
#include "tools/report/gshhg.h"
#include "tools/tiles/base_map.h"

namespace muster::tools {
namespace {

/// Packets taken at a time: readers wait no longer than for these.
constexpr std::size_t kBatch = 200;

}  // namespace

LiveFeed::LiveFeed(std::string name, std::unique_ptr<const TileFile> tiles)
    : name_(std::move(name)), tiles_(std::move(tiles)), feed_(std::in_place) {
  worker_ = StartQuietThread([this] { Work(); });
}

LiveFeed::~LiveFeed() {
  Close();
  worker_.join();
}

void LiveFeed::Add(std::vector<Packet> packets) {
  if (packets.empty()) return;
  const std::lock_guard lock(pending_mutex_);
  if (closed_) return;
  if (pending_.empty()) {
    pending_ = std::move(packets);
  } else {
    std::move(packets.begin(), packets.end(), std::back_inserter(pending_));
  }
  pending_changed_.notify_all();
}

void LiveFeed::Close() {
  const std::lock_guard lock(pending_mutex_);
  closed_ = true;
  pending_changed_.notify_all();
}

bool LiveFeed::closed() const {
  const std::lock_guard lock(pending_mutex_);
  return closed_;
}

void LiveFeed::Work() {
  std::vector<Packet> taken;
  while (true) {
    {
      std::unique_lock lock(pending_mutex_);
      pending_changed_.wait(lock, [this] { return closed_ || !pending_.empty(); });
      taken.swap(pending_);
      if (taken.empty()) break;
    }
    for (std::size_t begin = 0; begin < taken.size(); begin += kBatch) {
      const std::lock_guard lock(feed_mutex_);
      const std::size_t end = std::min(taken.size(), begin + kBatch);
      for (std::size_t i = begin; i < end; ++i) Take(taken[i]);
      ++version_;
      feed_changed_.notify_all();
    }
    taken.clear();
  }
  const std::lock_guard lock(feed_mutex_);
  worked_off_ = true;
  feed_changed_.notify_all();
}

void LiveFeed::Take(const Packet& packet) {
  if (packet.channel == channel::kScenario && feed_->ready() && feed_->timeline().ended()) {
    feed_.emplace();
    ++mission_;
  }
  feed_->Add(packet);
}

std::optional<std::string> LiveFeed::Next(Reader* reader, std::chrono::milliseconds wait) {
  std::unique_lock lock(feed_mutex_);
  const auto news = [&] { return feed_->ready() && reader->version != version_; };
  feed_changed_.wait_for(lock, wait, [&] { return news() || worked_off_; });
  if (!news()) return {};
  if (reader->mission != mission_) *reader = {{}, mission_, -1};
  reader->version = version_;
  const std::string& name = name_.empty() ? feed_->timeline().scenario().name : name_;
  auto chunk = PageChunk(*feed_, name, &reader->cursor, feed_->timeline().ended());
  const bool first = chunk.contains("scenario");
  const Scenario scenario = first ? feed_->timeline().scenario() : Scenario();
  lock.unlock();
  if (first) {
    std::string missing;  // a live page has no place for that
    if (auto coast = CoastOf("auto", scenario, &missing); !coast.is_null()) {
      chunk["coast"] = std::move(coast);
    }
    if (tiles_ != nullptr) {
      try {
        chunk["basemap"] = BaseMapOf(*tiles_, scenario);
      } catch (const InputError& error) {  // the mission is worth seeing without it
        fmt::print(stderr, "no base map: {}\n", error.what());
      }
    }
  }
  return chunk.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::optional<std::string> LiveFeed::GeoJson() const {
  const std::lock_guard lock(feed_mutex_);
  return feed_->ready() ? MissionGeoJson(feed_->timeline()) : std::nullopt;
}

std::optional<std::string> LiveFeed::Cap() const {
  const std::lock_guard lock(feed_mutex_);
  if (!feed_->ready()) return {};
  return MissionCap(feed_->timeline(), name_.empty() ? feed_->timeline().scenario().name : name_);
}

bool LiveFeed::worked_off() const {
  const std::lock_guard lock(feed_mutex_);
  return worked_off_;
}

}  // namespace muster::tools
