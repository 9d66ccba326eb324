#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "lcmtypes/bus/bus.h"
#include "tools/report/mission_feed.h"
#include "tools/report/page_chunk.h"
#include "tools/tiles/tile_file.h"

namespace muster::tools {

/// A mission that goes on, for several readers at once. One thread adds packets and is never kept
/// waiting by readers; any thread reads. When a mission has ended and another scenario comes, it is
/// that mission's from there on.
class LiveFeed {
 public:
  /// What one reader knows.
  struct Reader {
    PageCursor cursor;
    std::int64_t mission = -1;
    std::int64_t version = -1;
  };

  /// `name` of the run; "": the scenario's. `tiles`: the base map that readers are told of, if it
  /// is one of the mission's area; null: none.
  explicit LiveFeed(std::string name, std::unique_ptr<const TileFile> tiles = nullptr);
  ~LiveFeed();
  LiveFeed(const LiveFeed&) = delete;
  LiveFeed& operator=(const LiveFeed&) = delete;

  void Add(std::vector<Packet> packets);
  /// Readers that wait return, and nothing is taken any more.
  void Close();
  bool closed() const;

  /// The next chunk for that reader (PageChunk, as text), as soon as there is something new; none
  /// when `wait` is over, or the feed is closed and the reader knows all.
  std::optional<std::string> Next(Reader* reader, std::chrono::milliseconds wait);
  /// The mission as it is now, for maps (MissionGeoJson). None: it is not known yet, or nowhere on
  /// the earth.
  std::optional<std::string> GeoJson() const;
  /// The same for dispatch systems (MissionCap).
  std::optional<std::string> Cap() const;
  /// Null: there is none.
  const TileFile* tiles() const { return tiles_.get(); }
  /// It is closed, and all that it was given can be read.
  bool worked_off() const;

 private:
  void Work();
  void Take(const Packet& packet);

  const std::string name_;
  const std::unique_ptr<const TileFile> tiles_;
  mutable std::mutex pending_mutex_;
  std::condition_variable pending_changed_;
  std::vector<Packet> pending_;
  bool closed_ = false;

  mutable std::mutex feed_mutex_;
  std::condition_variable feed_changed_;
  std::optional<MissionFeed> feed_;
  std::int64_t mission_ = 0;
  std::int64_t version_ = 0;
  bool worked_off_ = false;  ///< closed, and all that was added is taken

  std::thread worker_;
};

}  // namespace muster::tools
