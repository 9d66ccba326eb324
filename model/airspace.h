#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <span>
#include <unordered_map>
#include <vector>

#include "base/geometry.h"
#include "base/grid_index.h"
#include "base/point_hash.h"
#include "model/zone.h"

namespace muster {

/// Where UAVs fly: straight, but around zones, by the shortest way that is at least a margin away
/// from each and stays in the area. docs/reference/zones.md has the rules; the auditor keeps them
/// by its own code.
///
/// A zone's edge, widened by a regular octagon whose sides touch the circle of the margin, is a
/// convex **piece**. A flight leads through the inside of no piece, so it turns at corners of
/// pieces only. Nothing but +, -, *, / and square roots is used, so every machine finds the same
/// flight, bit for bit. What was found is kept. Safe in several threads.
class Airspace {
  struct Known;

 public:
  /// Of the area that flights do not leave: from 0 to the east and to the north, metres.
  struct Extent {
    double width_m = std::numeric_limits<double>::infinity();
    double height_m = std::numeric_limits<double>::infinity();
    bool Contains(Point place) const {
      return place.x_m >= 0 && place.y_m >= 0 && place.x_m <= width_m && place.y_m <= height_m;
    }
  };
  Airspace(std::vector<Zone> zones, double margin_m, Extent extent);
  ~Airspace();

  /// Whether the place is outside all zones and their margins.
  bool IsFree(Point place) const;
  /// The zone that the place lies in or is too close to; none: it is free.
  std::optional<std::size_t> ZoneAt(Point place) const;

  /// From end to end. One that begins in a zone or its margin first leads to the nearest free
  /// place.
  struct Flight {
    std::vector<Point> corners;     ///< both ends included
    std::vector<double> reached_m;  ///< metres flown up to each corner; the first is 0
  };
  /// Metres; infinity: no flight leads there, as it lies in a zone or is enclosed by some.
  double Length(Point from, Point to) const;
  /// What Length() says of each of `from` and each of `to`, in less time: into `lengths_m`
  /// [from.size() * to.size()], all of the first of `from` first.
  void Lengths(std::span<const Point> from, std::span<const Point> to,
               std::span<double> lengths_m) const;
  /// Places that many flights lead to, looked up once. The airspace must outlive it.
  class Goals {
   public:
    Goals(const Airspace& air, std::span<const Point> places);
    /// What Length() says from there to those of the places, by index: into `lengths_m`
    /// [which.size()].
    void LengthsFrom(Point from, std::span<const std::int32_t> which,
                     std::span<double> lengths_m) const;

   private:
    const Airspace& air_;
    std::vector<std::shared_ptr<Known>> goals_;
  };
  /// Its last reached_m is the length. Null: there is none.
  std::shared_ptr<const Flight> FlightBetween(Point from, Point to) const;
  /// After how many of its metres, not before `begin_m`, a flight comes into one of the zones or
  /// its margin; none: it does not.
  std::optional<double> EntersAt(const Flight& flight, double begin_m) const;

 private:
  /// Inside are the places of which all sides have x * normal_x + y * normal_y below `limit`.
  struct Side {
    double normal_x, normal_y, limit;
  };
  struct Box {
    double x0, y0, x1, y1;
    bool Misses(Point a, Point b) const;
    void Add(const Box& other);
  };
  struct Piece {
    std::array<Side, 10> sides;
    Box box;
    Point a, b;  ///< the edge
  };
  struct Pieces {
    std::vector<Piece> pieces;
    Box box;
  };
  /// Of a tree of pieces: those from `first` to `end` of by_place_. Where they are more than a few,
  /// the next node has one half of them and `other_half` the rest.
  struct Node {
    Point centre, half;  ///< of the box around them
    std::size_t first, end, other_half;
  };
  /// Where flights can turn.
  struct Corner {
    Point at;
    /// Of both pieces that have it: the way along each of its two sides there.
    std::array<std::array<Point, 2>, 2> sides;
    /// Whether a flight from that place can turn there: the line leads past both pieces. If it led
    /// on into one of them, the flight would be shorter without that corner.
    bool TurnsFrom(Point place) const;
  };
  /// A corner in sight at which a flight can turn.
  struct Seen {
    std::int32_t corner;
    double metres;
  };
  /// The corners in sight of a place, ascending.
  struct Sight {
    double up_to_m;  ///< those that are no further away, and perhaps others
    std::vector<Seen> corners;
  };
  /// Shortest ways to a goal from corners.
  struct WaysTo {
    static constexpr std::int32_t kGoal = -1;
    struct Way {
      std::int32_t corner, next;  ///< next: a corner or kGoal
      double metres;
    };
    double up_to_m;              ///< those that are no longer
    std::vector<Way> ways;       ///< ascending by corner
    std::vector<double> metres;  ///< by corner, infinity: no way; empty where most have none
    const Way& From(std::int32_t corner) const;
  };
  /// What is found up to some distance, and again up to a greater one when that is asked for. What
  /// was found before stays in memory, as others may still look at it.
  template <class T>
  class UpTo {
   public:
    /// find() finds it at least up to there.
    template <class Find>
    const T& Get(double up_to_m, const Find& find) {
      const T* known = known_.load(std::memory_order_acquire);
      if (known != nullptr && known->up_to_m >= up_to_m) return *known;
      const std::lock_guard lock(mutex_);
      known = known_.load(std::memory_order_relaxed);
      if (known != nullptr && known->up_to_m >= up_to_m) return *known;
      all_.push_back(std::make_unique<const T>(find()));
      known_.store(all_.back().get(), std::memory_order_release);
      return *all_.back();
    }

   private:
    std::atomic<const T*> known_ = nullptr;
    std::mutex mutex_;
    std::vector<std::unique_ptr<const T>> all_;
  };
  class Start;

  /// The zone of which the place lies by more than that inside a piece, or in its midst.
  std::optional<std::size_t> ZoneAt(Point place, double rounding_m) const;
  static Piece Widened(Point a, Point b, double margin_m);
  /// The share of the line at which it enters the piece; none: it stays outside.
  static std::optional<double> EntersPiece(const Piece& piece, Point a, Point b);
  void FindCorners(double margin_m);
  /// Appends the node of those of by_place_, and below it the nodes of its halves.
  void AddNode(std::size_t first, std::size_t end);
  bool IsClear(Point a, Point b) const;
  /// What has been found out about a place; null: nothing.
  std::shared_ptr<Known> Find(Point place) const;
  /// It is made where there is none.
  std::shared_ptr<Known> KnownOf(Point place) const;
  std::vector<std::shared_ptr<Known>> GoalsAt(std::span<const Point> places) const;
  const Sight& SightFrom(Known* place, double up_to_m) const;
  const Sight& SightFromCorner(std::int32_t corner, double up_to_m) const;
  /// `here`: the corner that the place is; null: it is none.
  Sight FindSight(Point place, const Corner* here, double up_to_m) const;
  const WaysTo& WaysToGoal(Known* goal, double up_to_m) const;
  WaysTo FindWaysTo(Known* goal, double up_to_m) const;
  /// The nearest place that is free.
  std::optional<Point> WayOut(Point place) const;
  double LengthBetween(Known* from, Known* to) const;
  /// LengthBetween() without what is kept.
  double FindLength(Known* from, Known* to) const;
  /// Gives the place a number among the goals, as long as there are some left.
  void MakeGoal(Known* place) const;
  /// Where a flight turns at first, and the ways from there; no ways: at no corner.
  struct Turn {
    std::int32_t corner = WaysTo::kGoal;
    const WaysTo* on = nullptr;
  };
  /// Of a flight from a free place.
  double FreeLength(Known* from, Known* to, Turn* turn) const;

  std::vector<Zone> zones_;
  std::vector<Pieces> pieces_;          ///< of each zone
  std::vector<const Piece*> by_place_;  ///< of all zones, in the order of the tree
  double reach_m_;                      ///< no place of a piece is further away from its edge
  std::vector<Node> nodes_;             ///< each before its halves
  std::vector<Corner> corners_;
  std::optional<GridIndex> corner_places_;
  double wide_m_ = 0;                      ///< no two corners are further apart
  std::unique_ptr<UpTo<Sight>[]> sights_;  ///< [corner]
  Extent extent_;

  mutable std::shared_mutex mutex_;
  mutable std::unordered_map<Point, std::shared_ptr<Known>, PointHash> known_;
  mutable std::atomic<std::int32_t> n_goals_ = 0, n_others_ = 0;
};

}  // namespace muster
