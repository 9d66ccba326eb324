#pragma once

#include <compare>
#include <memory>
#include <optional>
#include <string>

#include "tools/tiles/degree_box.h"

namespace muster::tools {

/// A square of the web's map of the earth: at zoom z the earth is 2^z columns by 2^z rows wide, the
/// first column begins at 180 degrees west, the first row in the north.
struct TileId {
  int zoom = 0, column = 0, row = 0;
  auto operator<=>(const TileId&) const = default;
};

inline constexpr int kMostZoom = 24;

/// What a tile file says of itself. The box is the whole earth where it says nothing.
struct TileInfo {
  bool vector = false;  ///< shapes (Mapbox Vector Tile); else pictures
  std::string type;     ///< of a picture: "image/png"
  int min_zoom = 0, max_zoom = 0;
  DegreeBox box;
  std::string attribution;  ///< text that has to be shown; "": it has none
};

/// A file of map tiles, open to be read. Not for several threads at once.
class TileFile {
 public:
  explicit TileFile(std::string name) : name_(std::move(name)) {}
  virtual ~TileFile() = default;
  TileFile(const TileFile&) = delete;
  TileFile& operator=(const TileFile&) = delete;

  const std::string& name() const { return name_; }
  const TileInfo& info() const { return info_; }

  /// A picture as it is, or shapes unpacked. None: the file has no such tile. Throws InputError
  /// where the file contradicts itself.
  virtual std::optional<std::string> Read(const TileId& tile) const = 0;

 protected:
  void set_info(TileInfo info) { info_ = std::move(info); }

 private:
  const std::string name_;
  TileInfo info_;
};

/// Opens an MBTiles or a PMTiles (version 3) file, told apart by how it begins. Throws InputError
/// that names the file and what was expected.
std::unique_ptr<TileFile> OpenTiles(const std::string& file);

/// "<a href='..'>&copy; OpenStreetMap</a>" -> "© OpenStreetMap": as plain text, on one line.
std::string PlainText(const std::string& html);

/// The type of a picture by its first bytes; "": it is none that browsers show.
std::string PictureType(const std::string& bytes);

}  // namespace muster::tools
