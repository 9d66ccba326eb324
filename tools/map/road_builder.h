#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/geometry.h"
#include "model/roads.h"

namespace muster::tools {

inline constexpr double kRoadMargin_m = 1000;          ///< roads end so far outside the area
inline constexpr std::int64_t kMostStep_mm = 100'000;  ///< between neighbouring points of a road

/// What became of the lines.
struct BuiltRoads {
  Roads roads;
  std::size_t lines = 0;        ///< of those added: in the area or its margin
  std::size_t cut_off = 0;      ///< lines that no class reaches, left out
  std::int64_t cut_off_mm = 0;  ///< their length
  std::size_t joined = 0;       ///< points that were moved to another
  std::size_t barriers = 0;     ///< on the roads
  std::size_t junctions = 0;    ///< where three or more roads end
  std::int64_t length_mm = 0;   ///< of all roads
  std::int64_t driven_mm = 0;   ///< of those for vehicles
};

/// Makes a network of lines. Source: ours.
/// - Lines are cut at the border of the area and its margin; a cut end is a dead end.
/// - They meet where they have a point in common, to the millimetre, and nowhere else. With
///   `join_m` points that near become one: the one that was added first.
/// - A barrier closes a metre of each road there to vehicles.
/// - They are divided where they meet. Roads of one class that meet where nothing else does become
///   one. Of roads of one class with the same points the first is kept.
/// - Of each agent class the largest part is kept, by length, in which one gets from everywhere to
///   everywhere. Other roads are not for that class. Roads for no class are left out.
/// Roads are in the order of the lines, points in that of their first use.
class RoadBuilder {
 public:
  RoadBuilder(double width_m, double height_m, double join_m);

  /// A line through these places of the map frame; one of NaN is in no area. Its id need not be its
  /// own.
  void AddLine(std::int64_t id, const RoadClass& road_class, const std::vector<Point>& places);
  /// A place that vehicles do not pass.
  void AddBarrier(Point place);

  /// Whether any line is in the area or its margin.
  bool empty() const { return pieces_.empty(); }
  /// Throws InputError naming `file` when no road is left. Linear in the points, but for sorting.
  BuiltRoads Build(std::string source, const std::string& file) const;

 private:
  struct Spot {
    RoadPoint at;
    bool is_cut = false;  ///< by the border: no other line meets it
  };
  /// What is left of a line, or of a part of it.
  struct Piece {
    std::size_t line;
    std::vector<Spot> spots;
  };
  struct Line {
    std::int64_t id;
    std::int32_t road_class;
  };
  class Network;

  /// The parts of a way from a to b that are in the area; false: none. Shares are of it.
  bool Clip(Point a, Point b, double* enters, double* leaves) const;
  void Keep(std::vector<Spot> spots);

  const double east_m_, north_m_;
  const std::int64_t join_mm_;
  std::vector<RoadClass> classes_;
  std::vector<Line> lines_;
  std::vector<Piece> pieces_;
  std::vector<RoadPoint> barriers_;
};

}  // namespace muster::tools
