#include "tools/tiles/base_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "base/check.h"
#include "tools/files/packing.h"
#include "tools/map/local_frame.h"
#include "tools/tiles/vector_tile.h"

namespace muster::tools {
namespace {

using nlohmann::ordered_json;

constexpr double kAround = 0.1;            ///< of the area's longer side: what a map shows more
constexpr std::size_t kMostTiles = 512;    ///< of the zoom that a page has of all the area
constexpr std::size_t kMostCloser = 4096;  ///< of the next one
constexpr int kPageUnits = 1024;
/// Shapes as text, packed and in base64: what they take in a page.
constexpr double kPacked = 0.45;
constexpr double kMostLatitude = 85.0511;  ///< of the web's map
constexpr int kMostSide = 256;  ///< columns and rows that are looked at, around the middle

/// Tiles from the first to the last column and row, both included.
struct Range {
  int zoom = 0, first_column = 0, last_column = 0, first_row = 0, last_row = 0;
  std::size_t size() const {
    return static_cast<std::size_t>(last_column - first_column + 1) *
           static_cast<std::size_t>(last_row - first_row + 1);
  }
};

TileId TileAt(double latitude, double longitude, int zoom) {
  const int side = 1 << zoom;
  const auto cell = [&](double share) {
    return std::clamp(static_cast<int>(std::floor(share * side)), 0, side - 1);
  };
  const double phi = std::clamp(latitude, -kMostLatitude, kMostLatitude) * std::numbers::pi / 180;
  return {zoom, cell((longitude + 180) / 360),
          cell((1 - std::asinh(std::tan(phi)) / std::numbers::pi) / 2)};
}

Range RangeOf(const DegreeBox& box, int zoom) {
  const TileId corner = TileAt(box.north, box.west, zoom);
  const TileId opposite = TileAt(box.south, box.east, zoom);
  Range range = {zoom, corner.column, opposite.column, corner.row, opposite.row};
  const auto narrow = [](int* first, int* last) {
    const int beyond = std::max(0, *last - *first + 1 - kMostSide);
    *first += beyond / 2;
    *last -= beyond - beyond / 2;
  };
  narrow(&range.first_column, &range.last_column);
  narrow(&range.first_row, &range.last_row);
  return range;
}

void RequireOrigin(const TileFile& file, const Scenario& scenario) {
  if (scenario.origin) return;
  throw InputError(
      fmt::format("{}: scenario '{}' has no origin, so its map is nowhere on the earth",
                  file.name(), scenario.name));
}

DegreeBox AreaOf(const Scenario& scenario) {
  return BoxAround(scenario, kAround * std::max(scenario.width_m, scenario.height_m));
}

std::string TextOf(const DegreeBox& box) {
  return fmt::format("{:.3f} to {:.3f} N, {:.3f} to {:.3f} E", box.south, box.north, box.west,
                     box.east);
}

[[noreturn]] void RefusePlace(const TileFile& file, const Scenario& scenario) {
  throw InputError(file.name(), "its tiles", TextOf(file.info().box),
                   fmt::format("tiles of the area of scenario '{}', {}", scenario.name,
                               TextOf(BoxAround(scenario, 0))));
}

/// Bounds are what a file says of itself: it may have no tile where it says that it has some.
[[noreturn]] void RefuseEmpty(const TileFile& file, const Scenario& scenario) {
  throw InputError(
      file.name(), "its tiles",
      fmt::format("none in the area of scenario '{}', {}", scenario.name,
                  TextOf(BoxAround(scenario, 0))),
      fmt::format("at least one (the file says that it has those of {})", TextOf(file.info().box)));
}

void RequireSamePlace(const TileFile& file, const Scenario& scenario) {
  const DegreeBox &area = BoxAround(scenario, 0), &box = file.info().box;
  if (area.south < box.north && box.south < area.north && area.west < box.east &&
      box.west < area.east) {
    return;
  }
  RefusePlace(file, scenario);
}

ordered_json Head(const TileFile& file, int min_zoom, int max_zoom, int units) {
  const TileInfo& info = file.info();
  return {{"source", info.attribution},
          {"vector", info.vector},
          {"type", info.type},
          {"zooms", {min_zoom, max_zoom}},
          {"units", units}};
}

/// {x, y, x, y, ...} in units of the page, from the second place on as differences; without places
/// that are the same there. Empty: nothing is left of it.
ordered_json Flat(const std::vector<std::int32_t>& places, bool is_area, int units) {
  const auto to_page = [&](std::int32_t at) {
    return static_cast<int>(std::floor(static_cast<double>(at) * units / kTileUnits + 0.5));
  };
  ordered_json flat = ordered_json::array();
  int x = 0, y = 0;
  for (std::size_t i = 0; i < places.size(); i += 2) {
    const int next_x = to_page(places[i]), next_y = to_page(places[i + 1]);
    if (i > 0 && next_x == x && next_y == y) continue;
    flat.push_back(next_x - x);
    flat.push_back(next_y - y);
    x = next_x, y = next_y;
  }
  const std::size_t least = is_area ? 6 : 4;
  return flat.size() < least ? ordered_json::array() : flat;
}

/// All tiles, those in the middle first.
std::vector<TileId> FromTheMiddle(const Range& range) {
  std::vector<std::pair<double, TileId>> wanted;
  const double middle_x = (range.first_column + range.last_column) / 2.0;
  const double middle_y = (range.first_row + range.last_row) / 2.0;
  for (int row = range.first_row; row <= range.last_row; ++row) {
    for (int column = range.first_column; column <= range.last_column; ++column) {
      wanted.emplace_back(std::hypot(column - middle_x, row - middle_y),
                          TileId{range.zoom, column, row});
    }
  }
  std::sort(wanted.begin(), wanted.end());
  std::vector<TileId> tiles;
  for (const auto& [distance, id] : wanted) tiles.push_back(id);
  return tiles;
}

/// The tiles of a zoom in which tasks or charging points are, those with most of them first.
std::vector<TileId> WithPlaces(const Scenario& scenario, int zoom) {
  const LocalFrame frame(*scenario.origin);
  std::map<TileId, int> places;
  const auto count = [&](Point at) {
    const Origin place = frame.ToPlace(at);
    ++places[TileAt(place.latitude_deg, place.longitude_deg, zoom)];
  };
  for (std::size_t i = 0; i < scenario.n_tasks(); ++i) count(scenario.tasks[i].at);
  for (const ChargingPoint& point : scenario.charging_points) count(point.at);
  std::vector<TileId> tiles;
  for (const auto& [id, n] : places) tiles.push_back(id);
  std::stable_sort(tiles.begin(), tiles.end(),
                   [&](const TileId& a, const TileId& b) { return places[a] > places[b]; });
  return tiles;
}

/// Tiles in that order, until they take more than `most_bytes`.
struct Taken {
  ordered_json tiles = ordered_json::object();
  std::size_t n = 0, bytes = 0;
  bool whole = true;
};
Taken Take(const TileFile& file, const std::vector<TileId>& wanted, std::size_t most_bytes,
           std::size_t most_tiles) {
  Taken taken;
  for (const TileId& id : wanted) {
    const auto bytes = file.Read(id);
    if (!bytes) continue;
    ordered_json tile = TileForPage(file, *bytes, kPageUnits);
    const double packed = file.info().vector ? kPacked : 1;
    const auto size = static_cast<std::size_t>(
        packed * static_cast<double>(
                     tile.dump(-1, ' ', false, ordered_json::error_handler_t::replace).size()));
    if (taken.bytes + size > most_bytes || taken.n == most_tiles) {
      taken.whole = false;
      return taken;
    }
    taken.bytes += size;
    ++taken.n;
    taken.tiles[fmt::format("{}/{}/{}", id.zoom, id.column, id.row)] = std::move(tile);
  }
  return taken;
}

}  // namespace

ordered_json TileForPage(const TileFile& file, const std::string& bytes, int units) {
  if (!file.info().vector) return Base64(bytes);
  const auto ground = ReadVectorTile(bytes);
  if (!ground) {
    throw InputError(file.name(), "a tile", fmt::format("{} damaged bytes", bytes.size()),
                     "a Mapbox Vector Tile");
  }
  ordered_json shapes = ordered_json::array();
  for (int its_class = 0; its_class < kGroundClasses; ++its_class) {
    ordered_json all = ordered_json::array();
    for (const auto& places : ground->shapes[static_cast<std::size_t>(its_class)]) {
      ordered_json flat = Flat(places, IsArea(static_cast<GroundClass>(its_class)), units);
      if (!flat.empty()) all.push_back(std::move(flat));
    }
    shapes.push_back(std::move(all));
  }
  ordered_json names = ordered_json::array();
  for (const auto& name : ground->names) {
    names.push_back(
        {name.x * units / kTileUnits, name.y * units / kTileUnits, name.rank, name.text});
  }
  ordered_json streets = ordered_json::array();
  const auto to_page = [&](int at) { return at * units / kTileUnits; };
  for (const auto& [along, rank, text] : ground->streets) {
    streets.push_back(
        {to_page(along.x), to_page(along.y), to_page(along.dx), to_page(along.dy), rank, text});
  }
  return {
      {"shapes", std::move(shapes)}, {"names", std::move(names)}, {"streets", std::move(streets)}};
}

ordered_json AboutTiles(const TileFile& file) {
  return Head(file, file.info().min_zoom, file.info().max_zoom, kLiveTileUnits);
}

ordered_json BaseMapOf(const TileFile& file, const Scenario& scenario) {
  RequireOrigin(file, scenario);
  RequireSamePlace(file, scenario);
  return AboutTiles(file);
}

ordered_json EmbeddedBaseMap(const TileFile& file, const Scenario& scenario, std::size_t most_bytes,
                             std::string* told) {
  RequireOrigin(file, scenario);
  RequireSamePlace(file, scenario);
  const DegreeBox area = AreaOf(scenario);
  std::optional<Taken> best;
  int zoom = 0;
  double best_share = 0;  // of the area's tiles that the file has
  for (int next = file.info().min_zoom; next <= file.info().max_zoom; ++next) {
    const Range range = RangeOf(area, next);
    if (best && range.size() > kMostTiles) break;
    Taken taken = Take(file, FromTheMiddle(range), most_bytes, kMostTiles);
    if (best && !taken.whole) break;
    const double share = static_cast<double>(taken.n) / static_cast<double>(range.size());
    if (share < best_share / 4 || taken.n == 0) continue;  // it ends at a lower zoom there
    best_share = std::max(share, best_share);
    best = std::move(taken);
    zoom = next;
    if (!best->whole) break;
  }
  if (!best) RefuseEmpty(file, scenario);
  Taken closer;
  if (best->whole && zoom < file.info().max_zoom) {
    closer = Take(file, WithPlaces(scenario, zoom + 1), most_bytes - best->bytes, kMostCloser);
  }
  *told = fmt::format(
      "{} tile{} of zoom {}{}, {:.0f} kB{}", best->n, best->n == 1 ? "" : "s", zoom,
      closer.n == 0 ? "" : fmt::format(" and {} of zoom {} around tasks", closer.n, zoom + 1),
      static_cast<double>(best->bytes + closer.bytes) / 1000,
      best->whole ? "" : ", the middle of the area: all of it takes more");
  ordered_json map = Head(file, zoom, closer.n == 0 ? zoom : zoom + 1, kPageUnits);
  map["tiles"] = std::move(best->tiles);
  map["tiles"].update(closer.tiles);
  return map;
}

}  // namespace muster::tools
