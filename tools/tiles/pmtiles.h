#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "tools/tiles/tile_file.h"

namespace muster::tools {

/// PMTiles, version 3: tiles one after the other, found by directories of their numbers. Source:
/// PMTiles specification 3.6. Throws InputError.
std::unique_ptr<TileFile> OpenPmtiles(const std::string& file);

/// The number of a tile there: along a Hilbert curve through its zoom, after all lower zooms.
std::uint64_t PmtilesNumber(const TileId& tile);

}  // namespace muster::tools
