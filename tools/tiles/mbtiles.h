#pragma once

#include <memory>
#include <string>

#include "tools/tiles/tile_file.h"

namespace muster::tools {

/// MBTiles: a database of SQLite. Source: MBTiles specification 1.3. Throws InputError.
std::unique_ptr<TileFile> OpenMbtiles(const std::string& file);

}  // namespace muster::tools
