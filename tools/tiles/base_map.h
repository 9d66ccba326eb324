#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "model/scenario.h"
#include "tools/tiles/tile_file.h"

namespace muster::tools {

/// Of the shapes that a live page asks for: units to a tile's side.
inline constexpr int kLiveTileUnits = 4096;

/// One tile for the page. A picture: in base64. Shapes: {"shapes": [[[x, y, then differences],
/// ...], ... by GroundClass], "names": [[x, y, rank, text], ...], "streets": [[x, y, dx, dy, rank,
/// text], ...]} in `units` to a tile's side.
/// Throws InputError where the tile is damaged.
nlohmann::ordered_json TileForPage(const TileFile& file, const std::string& bytes, int units);

/// What the file holds, for pages that ask a live server for its tiles: {"source", "vector",
/// "type", "zooms": [from, to], "units"}.
nlohmann::ordered_json AboutTiles(const TileFile& file);

/// AboutTiles(). Throws InputError when the scenario has no origin, or the file no tile of its
/// area.
nlohmann::ordered_json BaseMapOf(const TileFile& file, const Scenario& scenario);

/// The same with "tiles": {"zoom/column/row": TileForPage}: the scenario's area and some more at
/// the highest zoom at which it takes no more than `most_bytes`. Where even the lowest takes more,
/// the tiles nearest to the middle. With the bytes that are left, tiles of the next zoom with tasks
/// and charging points, those with most of them first. `told`: "42 tiles of zoom 12 and 9 of zoom
/// 13 around tasks, 812 kB".
nlohmann::ordered_json EmbeddedBaseMap(const TileFile& file, const Scenario& scenario,
                                       std::size_t most_bytes, std::string* told);

}  // namespace muster::tools
