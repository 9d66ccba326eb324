#include "tools/tiles/mbtiles.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cstdint>
#include <cstdio>
#include <map>
#include <utility>

#include "base/check.h"
#include "tools/files/packing.h"

namespace muster::tools {
namespace {

constexpr const char* kExpectedMbtiles = "an MBTiles file: the tables metadata and tiles";
constexpr std::size_t kMostTileBytes = std::size_t{1} << 24;
/// Steps of SQLite's machine for one question: a second or so. A file whose tiles have no index
/// needs more.
constexpr int kMostSteps = 20'000'000;

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
};
struct CloseStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Database = std::unique_ptr<sqlite3, CloseDatabase>;
using Statement = std::unique_ptr<sqlite3_stmt, CloseStatement>;

class Mbtiles final : public TileFile {
 public:
  explicit Mbtiles(const std::string& file) : TileFile(file) {
    sqlite3* database = nullptr;
    const int result = sqlite3_open_v2(file.c_str(), &database, SQLITE_OPEN_READONLY, nullptr);
    database_.reset(database);
    if (result != SQLITE_OK) Refuse("the file", sqlite3_errmsg(database));
    // The file may be anybody's: what it defines as views may call no functions.
    sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_limit(database, SQLITE_LIMIT_LENGTH, kMostTileBytes);
    sqlite3_progress_handler(
        database, kMostSteps / 100,
        [](void* steps) { return --*static_cast<int*>(steps) < 0 ? 1 : 0; }, &steps_left_);
    set_info(ReadInfo());
    tile_ = Prepare(
        "select tile_data from tiles where zoom_level = ? and tile_column = ? and tile_row = ?");
  }

  std::optional<std::string> Read(const TileId& tile) const override {
    sqlite3_reset(tile_.get());
    sqlite3_bind_int(tile_.get(), 1, tile.zoom);
    sqlite3_bind_int(tile_.get(), 2, tile.column);
    sqlite3_bind_int(tile_.get(), 3, (1 << tile.zoom) - 1 - tile.row);  // counted from the south
    if (!Step(tile_.get())) return {};
    std::string bytes = TextOf(tile_.get(), 0);
    sqlite3_reset(tile_.get());
    if (!info().vector || !IsGzip(bytes)) return bytes;
    auto shapes = Gunzip(bytes, kMostTileBytes);
    if (!shapes) {
      Refuse(fmt::format("tile {}/{}/{}", tile.zoom, tile.column, tile.row), "damaged gzip");
    }
    return shapes;
  }

 private:
  [[noreturn]] void Refuse(std::string_view key, std::string_view found) const {
    throw InputError(name(), key, found, kExpectedMbtiles);
  }

  Statement Prepare(const char* sql) const {
    sqlite3_stmt* statement = nullptr;
    steps_left_ = 100;
    if (sqlite3_prepare_v2(database_.get(), sql, -1, &statement, nullptr) != SQLITE_OK) {
      Refuse("the file", sqlite3_errmsg(database_.get()));
    }
    return Statement(statement);
  }

  /// Whether there is a row.
  bool Step(sqlite3_stmt* statement) const {
    steps_left_ = 100;
    const int result = sqlite3_step(statement);
    if (result == SQLITE_ROW) return true;
    if (result == SQLITE_INTERRUPT) Refuse("tiles", "no index: looking for a tile takes too long");
    if (result != SQLITE_DONE) Refuse("tiles", sqlite3_errmsg(database_.get()));
    return false;
  }

  static std::string TextOf(sqlite3_stmt* statement, int column) {
    const auto* bytes = static_cast<const char*>(sqlite3_column_blob(statement, column));
    const int size = sqlite3_column_bytes(statement, column);
    return bytes == nullptr ? "" : std::string(bytes, static_cast<std::size_t>(size));
  }

  TileInfo ReadInfo() const {
    std::map<std::string, std::string> metadata;
    const Statement rows = Prepare("select name, value from metadata");
    while (Step(rows.get())) metadata[TextOf(rows.get(), 0)] = TextOf(rows.get(), 1);
    TileInfo info;
    const Statement one = Prepare("select tile_data from tiles limit 1");
    if (!Step(one.get())) Refuse("tiles", "none");
    info.type = PictureType(TextOf(one.get(), 0));
    const std::string format = metadata["format"];
    info.vector = info.type.empty();
    if (info.vector && format != "pbf") {
      throw InputError(name(), "format", format.empty() ? "nothing" : format,
                       "png, jpg, webp or pbf");
    }
    const Statement zooms = Prepare("select min(zoom_level), max(zoom_level) from tiles");
    Step(zooms.get());
    info.min_zoom = sqlite3_column_int(zooms.get(), 0);
    info.max_zoom = sqlite3_column_int(zooms.get(), 1);
    if (info.min_zoom < 0 || info.max_zoom > kMostZoom) {
      Refuse("zoom_level", fmt::format("{} to {}", info.min_zoom, info.max_zoom));
    }
    info.box = {-90, -180, 90, 180};
    DegreeBox box;
    if (std::sscanf(metadata["bounds"].c_str(), "%lf,%lf,%lf,%lf", &box.west, &box.south, &box.east,
                    &box.north) == 4) {
      info.box = box;
    }
    info.attribution = PlainText(metadata["attribution"]);
    return info;
  }

  Database database_;
  Statement tile_;
  mutable int steps_left_ = 0;  ///< hundredths of kMostSteps
};

}  // namespace

std::unique_ptr<TileFile> OpenMbtiles(const std::string& file) {
  return std::make_unique<Mbtiles>(file);
}

}  // namespace muster::tools
