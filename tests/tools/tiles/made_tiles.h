#pragma once

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cstdint>
#include <fstream>
#include <map>
#include <protozero/pbf_writer.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tools/tiles/pmtiles.h"
#include "tools/tiles/tile_file.h"

namespace muster::tools {

using Tiles = std::map<TileId, std::string>;

/// Writes an MBTiles file.
inline void WriteMbtiles(const std::string& file,
                         const std::map<std::string, std::string>& metadata, const Tiles& tiles) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  const auto run = [&](const char* sql) {
    ASSERT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(database);
  };
  run("begin");
  run("create table metadata (name text, value text)");
  run("create table tiles (zoom_level integer, tile_column integer, tile_row integer,"
      " tile_data blob)");
  const auto insert = [&](const char* sql, const auto& bind) {
    sqlite3_stmt* statement = nullptr;
    ASSERT_EQ(sqlite3_prepare_v2(database, sql, -1, &statement, nullptr), SQLITE_OK);
    bind(statement);
    ASSERT_EQ(sqlite3_step(statement), SQLITE_DONE);
    sqlite3_finalize(statement);
  };
  for (const auto& [name, value] : metadata) {
    insert("insert into metadata values (?, ?)", [&, &n = name, &v = value](sqlite3_stmt* s) {
      sqlite3_bind_text(s, 1, n.c_str(), -1, SQLITE_TRANSIENT);
      sqlite3_bind_text(s, 2, v.c_str(), -1, SQLITE_TRANSIENT);
    });
  }
  for (const auto& [id, bytes] : tiles) {
    insert("insert into tiles values (?, ?, ?, ?)", [&, &t = id, &b = bytes](sqlite3_stmt* s) {
      sqlite3_bind_int(s, 1, t.zoom);
      sqlite3_bind_int(s, 2, t.column);
      sqlite3_bind_int(s, 3, (1 << t.zoom) - 1 - t.row);
      sqlite3_bind_blob(s, 4, b.data(), static_cast<int>(b.size()), SQLITE_TRANSIENT);
    });
  }
  run("create unique index places on tiles (zoom_level, tile_column, tile_row)");
  run("commit");
  sqlite3_close(database);
}

inline std::string Varint(std::uint64_t value) {
  std::string bytes;
  protozero::add_varint_to_buffer(&bytes, value);
  return bytes;
}

/// Of consecutive entries of a PMTiles directory: {number, run, length, offset}.
using Entries = std::vector<std::array<std::uint64_t, 4>>;
inline std::string DirectoryBytes(const Entries& entries) {
  std::string bytes = Varint(entries.size());
  std::uint64_t before = 0;
  for (const auto& entry : entries) {
    bytes += Varint(entry[0] - before);
    before = entry[0];
  }
  for (const auto& entry : entries) bytes += Varint(entry[1]);
  for (const auto& entry : entries) bytes += Varint(entry[2]);
  for (const auto& entry : entries) bytes += Varint(entry[3] + 1);
  return bytes;
}

/// A PMTiles file without compression, of tiles of that type; `leaves`: entries are in a directory
/// below the root.
inline std::string PmtilesBytes(const Tiles& tiles, int type, const std::string& metadata,
                                bool leaves) {
  std::map<std::uint64_t, std::string> by_number;
  int min_zoom = kMostZoom, max_zoom = 0;
  for (const auto& [id, bytes] : tiles) {
    by_number[PmtilesNumber(id)] = bytes;
    min_zoom = std::min(min_zoom, id.zoom);
    max_zoom = std::max(max_zoom, id.zoom);
  }
  std::string data;
  Entries entries;
  for (const auto& [number, bytes] : by_number) {
    entries.push_back({number, 1, bytes.size(), data.size()});
    data += bytes;
  }
  const std::string all = DirectoryBytes(entries);
  const std::string root =
      leaves ? DirectoryBytes({{by_number.begin()->first, 0, all.size(), 0}}) : all;
  const std::string leaf = leaves ? all : "";
  const auto number = [](std::uint64_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xFF);
    return text;
  };
  const std::uint64_t root_at = 127, metadata_at = root_at + root.size();
  const std::uint64_t leaf_at = metadata_at + metadata.size(), data_at = leaf_at + leaf.size();
  std::string file = "PMTiles\x03";
  for (const std::uint64_t value :
       {root_at, static_cast<std::uint64_t>(root.size()), metadata_at,
        static_cast<std::uint64_t>(metadata.size()), leaf_at,
        static_cast<std::uint64_t>(leaf.size()), data_at, static_cast<std::uint64_t>(data.size()),
        std::uint64_t{0}, std::uint64_t{0}, std::uint64_t{0}}) {
    file += number(value, 8);
  }
  file += std::string("\0\x01\x01", 3) + static_cast<char>(type);
  file += static_cast<char>(min_zoom);
  file += static_cast<char>(max_zoom);
  for (const double degrees : {-180.0, -85.0, 180.0, 85.0}) {
    file += number(static_cast<std::uint32_t>(static_cast<std::int32_t>(degrees * 1e7)), 4);
  }
  file += std::string(9, '\0');
  EXPECT_EQ(file.size(), 127U);
  return file + root + metadata + leaf + data;
}

inline void WriteBytes(const std::string& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

/// A feature of a vector tile's layer.
struct MadeFeature {
  int type = 2;  ///< 1 point, 2 line, 3 polygon
  std::vector<std::pair<std::string, std::string>> tags;
  std::vector<std::vector<std::pair<int, int>>> parts;
};

/// A Mapbox Vector Tile, by another library's writer.
inline std::string LayerBytes(const std::string& name, const std::vector<MadeFeature>& features,
                              std::uint32_t extent = 4096) {
  std::vector<std::string> keys, values;
  const auto index = [](std::vector<std::string>* all, const std::string& text) {
    all->push_back(text);
    return static_cast<std::uint32_t>(all->size() - 1);
  };
  std::string layer;
  protozero::pbf_writer writer(layer);
  writer.add_uint32(15, 2);
  writer.add_string(1, name);
  for (const MadeFeature& made : features) {
    protozero::pbf_writer feature(writer, 2);
    std::vector<std::uint32_t> tags, geometry;
    for (const auto& [key, value] : made.tags) {
      tags.push_back(index(&keys, key));
      tags.push_back(index(&values, value));
    }
    feature.add_packed_uint32(2, tags.begin(), tags.end());
    feature.add_enum(3, made.type);
    int x = 0, y = 0;
    for (const auto& part : made.parts) {
      const auto to = [&](std::pair<int, int> place) {
        geometry.push_back(protozero::encode_zigzag32(place.first - x));
        geometry.push_back(protozero::encode_zigzag32(place.second - y));
        std::tie(x, y) = place;
      };
      geometry.push_back(1 << 3 | 1);
      to(part.front());
      if (part.size() > 1) {
        geometry.push_back(static_cast<std::uint32_t>(part.size() - 1) << 3 | 2);
        for (std::size_t i = 1; i < part.size(); ++i) to(part[i]);
      }
      if (made.type == 3) geometry.push_back(1 << 3 | 7);
    }
    feature.add_packed_uint32(4, geometry.begin(), geometry.end());
  }
  for (const std::string& key : keys) writer.add_string(3, key);
  for (const std::string& text : values) {
    protozero::pbf_writer value(writer, 4);
    value.add_string(1, text);
  }
  writer.add_uint32(5, extent);
  std::string tile;
  protozero::pbf_writer(tile).add_message(3, layer);
  return tile;
}

}  // namespace muster::tools
