#include "tools/tiles/pmtiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/check.h"
#include "tools/files/packing.h"

namespace muster::tools {
namespace {

constexpr std::size_t kHeaderBytes = 127;
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 24;  ///< of a directory or a tile
constexpr std::uint64_t kMostEntries = 1 << 21;
constexpr int kMostLevels = 4;  ///< of directories below each other
constexpr std::size_t kMostLeaves = 64;
constexpr int kGzip = 2;
constexpr const char* kExpectedPmtiles = "a PMTiles file of version 3";

struct TileEntry {
  std::uint64_t number = 0, offset = 0, length = 0;
  std::uint64_t run = 0;  ///< tiles that are the same; 0: a directory of its own
};
using Directory = std::vector<TileEntry>;

class Pmtiles final : public TileFile {
 public:
  explicit Pmtiles(const std::string& file) : TileFile(file), in_(file, std::ios::binary) {
    header_ = Bytes(0, kHeaderBytes, "header");
    if (header_[7] != 3) Refuse("version", fmt::format("{}", int{header_[7]}));
    leaves_at_ = Number(40);
    tiles_at_ = Number(56);
    root_ = ReadDirectory(Number(8), Number(16));
    set_info(ReadInfo());
  }

  std::optional<std::string> Read(const TileId& tile) const override {
    const std::uint64_t number = PmtilesNumber(tile);
    const Directory* directory = &root_;
    for (int level = 0; level < kMostLevels; ++level) {
      const auto next = std::upper_bound(
          directory->begin(), directory->end(), number,
          [](std::uint64_t wanted, const TileEntry& entry) { return wanted < entry.number; });
      if (next == directory->begin()) return {};
      const TileEntry& entry = *(next - 1);
      if (entry.run > 0) {
        if (number - entry.number >= entry.run) return {};
        const std::string key = fmt::format("tile {}/{}/{}", tile.zoom, tile.column, tile.row);
        std::string bytes = Bytes(tiles_at_ + entry.offset, entry.length, key);
        return header_[98] == kGzip ? Unpacked(bytes, key) : bytes;
      }
      directory = &Leaf(entry);
    }
    Refuse("directories", "more than 4 levels");
  }

 private:
  [[noreturn]] void Refuse(std::string_view key, std::string_view found) const {
    throw InputError(name(), key, found, kExpectedPmtiles);
  }

  std::uint64_t Number(std::size_t at, int bytes = 8) const {
    std::uint64_t value = 0;
    for (int i = bytes; i-- > 0;) {
      value = value << 8 | static_cast<unsigned char>(header_[at + static_cast<std::size_t>(i)]);
    }
    return value;
  }

  double Degrees(std::size_t at) const {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(Number(at, 4))) / 1e7;
  }

  std::string Bytes(std::uint64_t at, std::uint64_t n, std::string_view key) const {
    if (n > kMostBytes) Refuse(key, fmt::format("{} bytes", n));
    std::string bytes(n, '\0');
    in_.clear();
    in_.seekg(static_cast<std::streamoff>(std::min<std::uint64_t>(at, INT64_MAX)));
    in_.read(bytes.data(), static_cast<std::streamsize>(n));
    if (!in_) Refuse(key, "the end of the file");
    return bytes;
  }

  std::string Unpacked(const std::string& bytes, std::string_view key) const {
    auto text = Gunzip(bytes, kMostBytes);
    if (!text) Refuse(key, "damaged gzip");
    return *std::move(text);
  }

  Directory ReadDirectory(std::uint64_t at, std::uint64_t length) const {
    std::string bytes = Bytes(at, length, "directory");
    if (header_[97] == kGzip) bytes = Unpacked(bytes, "directory");
    std::size_t read = 0;
    const auto next = [&] {
      std::uint64_t value = 0;
      for (int shift = 0; shift < 64; shift += 7) {
        if (read == bytes.size()) break;
        const auto byte = static_cast<unsigned char>(bytes[read++]);
        value |= std::uint64_t{byte & 0x7Fu} << shift;
        if (byte < 0x80) return value;
      }
      Refuse("directory", "a number without an end");
    };
    const std::uint64_t n = next();
    if (n > kMostEntries || n > bytes.size()) Refuse("directory", fmt::format("{} entries", n));
    Directory entries(n);
    std::uint64_t number = 0;
    for (TileEntry& entry : entries) entry.number = number += next();
    for (TileEntry& entry : entries) entry.run = next();
    for (TileEntry& entry : entries) entry.length = next();
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const std::uint64_t value = next();
      if (value == 0 && i == 0) Refuse("directory", "a first entry after another");
      entries[i].offset = value > 0 ? value - 1 : entries[i - 1].offset + entries[i - 1].length;
    }
    return entries;
  }

  const Directory& Leaf(const TileEntry& entry) const {
    const auto found = leaves_.find(entry.offset);
    if (found != leaves_.end()) return found->second;
    if (leaves_.size() >= kMostLeaves) leaves_.clear();
    Directory leaf = ReadDirectory(leaves_at_ + entry.offset, entry.length);
    return leaves_.emplace(entry.offset, std::move(leaf)).first->second;
  }

  TileInfo ReadInfo() const {
    for (const std::size_t at : {97, 98}) {
      if (header_[at] == 1 || header_[at] == kGzip) continue;
      throw InputError(name(), at == 97 ? "internal compression" : "tile compression",
                       fmt::format("number {}", int{header_[at]}), "none (1) or gzip (2)");
    }
    static const std::map<int, const char*> kTypes = {
        {2, "image/png"}, {3, "image/jpeg"}, {4, "image/webp"}, {5, "image/avif"}};
    TileInfo info;
    info.vector = header_[99] == 1;
    if (const auto type = kTypes.find(header_[99]); type != kTypes.end()) info.type = type->second;
    if (!info.vector && info.type.empty()) {
      throw InputError(name(), "tile type", fmt::format("number {}", int{header_[99]}),
                       "vector tiles (1), PNG (2), JPEG (3), WebP (4) or AVIF (5)");
    }
    info.min_zoom = static_cast<unsigned char>(header_[100]);
    info.max_zoom = static_cast<unsigned char>(header_[101]);
    if (info.min_zoom > info.max_zoom || info.max_zoom > kMostZoom) {
      Refuse("zoom", fmt::format("{} to {}", info.min_zoom, info.max_zoom));
    }
    info.box = {Degrees(106), Degrees(102), Degrees(114), Degrees(110)};
    std::string text = Bytes(Number(24), Number(32), "metadata");
    if (header_[97] == kGzip && !text.empty()) text = Unpacked(text, "metadata");
    const auto metadata = nlohmann::json::parse(text, nullptr, false);
    if (metadata.is_object()) {
      const auto said = metadata.find("attribution");
      if (said != metadata.end() && said->is_string()) {
        info.attribution = PlainText(said->get<std::string>());
      }
    }
    return info;
  }

  mutable std::ifstream in_;
  std::string header_;
  std::uint64_t leaves_at_ = 0, tiles_at_ = 0;
  Directory root_;
  mutable std::map<std::uint64_t, Directory> leaves_;  ///< by offset
};

}  // namespace

std::uint64_t PmtilesNumber(const TileId& tile) {
  std::uint64_t number = 0;
  for (int zoom = 0; zoom < tile.zoom; ++zoom) number += std::uint64_t{1} << (2 * zoom);
  auto x = static_cast<std::uint64_t>(tile.column), y = static_cast<std::uint64_t>(tile.row);
  for (std::uint64_t side = std::uint64_t{1} << tile.zoom >> 1; side > 0; side /= 2) {
    const std::uint64_t right = (x & side) > 0 ? 1 : 0, down = (y & side) > 0 ? 1 : 0;
    number += side * side * ((3 * right) ^ down);
    if (down > 0) continue;
    if (right > 0) {
      x = side - 1 - (x & (side - 1));
      y = side - 1 - (y & (side - 1));
    }
    std::swap(x, y);
  }
  return number;
}

std::unique_ptr<TileFile> OpenPmtiles(const std::string& file) {
  return std::make_unique<Pmtiles>(file);
}

}  // namespace muster::tools
