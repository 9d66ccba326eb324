#include "tools/tiles/tile_file.h"

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <utility>

#include "base/check.h"
#include "tools/tiles/mbtiles.h"
#include "tools/tiles/pmtiles.h"

namespace muster::tools {

std::unique_ptr<TileFile> OpenTiles(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::string begin(16, '\0');
  if (!in) throw InputError(fmt::format("{}: cannot read map tiles from it", file));
  in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(in.gcount()));
  if (begin.starts_with("SQLite format 3")) return OpenMbtiles(file);
  if (begin.starts_with("PMTiles")) return OpenPmtiles(file);
  throw InputError(file, "its beginning", "that of another kind of file",
                   "map tiles: an MBTiles or a PMTiles file (web Mercator)");
}

std::string PlainText(const std::string& html) {
  std::string text;
  bool in_tag = false;
  for (const char c : html) {
    if (c == '<') in_tag = true;
    const bool is_control = static_cast<unsigned char>(c) < 0x20;
    if (!in_tag) text += is_control ? ' ' : c;
    if (c == '>') in_tag = false;
  }
  constexpr std::array<std::pair<const char*, const char*>, 4> kNames = {
      {{"&copy;", "©"}, {"&lt;", "<"}, {"&gt;", ">"}, {"&amp;", "&"}}};
  for (const auto& [name, character] : kNames) {
    for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos;) {
      text.replace(at, std::string(name).size(), character);
      at += std::string(character).size();
    }
  }
  return text;
}

std::string PictureType(const std::string& bytes) {
  if (bytes.starts_with("\x89PNG")) return "image/png";
  if (bytes.starts_with("\xFF\xD8\xFF")) return "image/jpeg";
  if (bytes.starts_with("RIFF") && bytes.substr(0, 12).ends_with("WEBP")) return "image/webp";
  return "";
}

}  // namespace muster::tools
