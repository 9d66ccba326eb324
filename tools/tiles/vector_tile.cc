#include "tools/tiles/vector_tile.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <protozero/pbf_message.hpp>
#include <string_view>
#include <utility>

#include "tools/tiles/ground_class.h"

namespace muster::tools {
namespace {

// Field numbers of the specification.
enum class TileField : protozero::pbf_tag_type { kLayer = 3 };
enum class LayerField : protozero::pbf_tag_type {
  kName = 1,
  kFeature = 2,
  kKey = 3,
  kValue = 4,
  kExtent = 5
};
enum class FeatureField : protozero::pbf_tag_type { kTags = 2, kType = 3, kGeometry = 4 };
enum class ValueField : protozero::pbf_tag_type { kString = 1 };

enum Type { kPoint = 1, kLine = 2, kPolygon = 3 };
enum Command { kMoveTo = 1, kLineTo = 2, kClosePath = 7 };

/// Keys that the schemas give a feature's kind by, the more exact first.
constexpr std::array<std::string_view, 6> kKindKeys = {"kind_detail", "pmap:kind_detail", "class",
                                                       "kind",        "pmap:kind",        "type"};
/// Keys of a place's name: its own one first.
constexpr std::array<std::string_view, 3> kNameKeys = {"name", "name:latin", "name_en"};
constexpr std::size_t kMostPlaces = 1 << 20;  ///< of a tile's shapes
constexpr std::size_t kMostStreets = 100;     ///< of a tile that are named

struct Layer {
  std::string_view name;
  std::uint32_t extent = kTileUnits;
  std::vector<std::string_view> keys, values;  ///< of a value that is no text: ""
};

struct Feature {
  int type = 0;
  std::vector<std::uint32_t> tags;
  std::vector<std::vector<std::int32_t>> parts;
};

class Reader {
 public:
  GroundShapes Take(const std::string& bytes) {
    shapes_.shapes.resize(kGroundClasses);
    protozero::pbf_message<TileField> tile(bytes);
    while (tile.next(TileField::kLayer)) TakeLayer(tile.get_view());
    for (auto& [text, street] : streets_) shapes_.streets.push_back(std::move(street));
    std::stable_sort(
        shapes_.streets.begin(), shapes_.streets.end(), [](const auto& a, const auto& b) {
          return std::pair(a.rank, -a.along.Length()) < std::pair(b.rank, -b.along.Length());
        });
    shapes_.streets.resize(std::min(shapes_.streets.size(), kMostStreets));
    return std::move(shapes_);
  }

 private:
  void TakeLayer(protozero::data_view bytes) {
    Layer layer;
    protozero::pbf_message<LayerField> head(bytes);
    while (head.next()) {
      switch (head.tag()) {
        case LayerField::kName:
          layer.name = ViewOf(head.get_view());
          break;
        case LayerField::kKey:
          layer.keys.push_back(ViewOf(head.get_view()));
          break;
        case LayerField::kValue:
          layer.values.push_back(TextOf(head.get_view()));
          break;
        case LayerField::kExtent:
          layer.extent = std::max<std::uint32_t>(1, head.get_uint32());
          break;
        default:
          head.skip();
      }
    }
    protozero::pbf_message<LayerField> features(bytes);
    while (features.next(LayerField::kFeature)) TakeFeature(layer, features.get_view());
  }

  static std::string_view ViewOf(protozero::data_view view) { return {view.data(), view.size()}; }

  static std::string_view TextOf(protozero::data_view bytes) {
    protozero::pbf_message<ValueField> value(bytes);
    return value.next(ValueField::kString) ? ViewOf(value.get_view()) : "";
  }

  static std::string_view ValueOf(const Layer& layer, const Feature& feature,
                                  std::string_view key) {
    for (std::size_t i = 0; i + 1 < feature.tags.size(); i += 2) {
      if (feature.tags[i] >= layer.keys.size() || feature.tags[i + 1] >= layer.values.size()) {
        throw protozero::exception();
      }
      if (layer.keys[feature.tags[i]] == key) return layer.values[feature.tags[i + 1]];
    }
    return "";
  }

  void TakeFeature(const Layer& layer, protozero::data_view bytes) {
    Feature feature;
    protozero::data_view geometry;
    protozero::pbf_message<FeatureField> fields(bytes);
    while (fields.next()) {
      switch (fields.tag()) {
        case FeatureField::kTags: {
          const auto tags = fields.get_packed_uint32();
          feature.tags.assign(tags.begin(), tags.end());
          break;
        }
        case FeatureField::kType:
          feature.type = fields.get_enum();
          break;
        case FeatureField::kGeometry:
          geometry = fields.get_view();
          break;
        default:
          fields.skip();
      }
    }
    if (feature.type == kPoint) return TakeName(layer, &feature, geometry);
    if (feature.type != kLine && feature.type != kPolygon) return;
    const bool is_named = feature.type == kLine && TakeStreet(layer, &feature, geometry);
    for (const std::string_view key : kKindKeys) {
      const auto its_class =
          ClassOf(layer.name, ValueOf(layer, feature, key), feature.type == kPolygon);
      if (!its_class) continue;
      if (!is_named) Follow(layer, geometry, &feature);
      auto& all = shapes_.shapes[static_cast<std::size_t>(*its_class)];
      std::move(feature.parts.begin(), feature.parts.end(), std::back_inserter(all));
      return;
    }
  }

  static std::string_view NameOf(const Layer& layer, const Feature& feature) {
    for (const std::string_view key : kNameKeys) {
      if (const std::string_view text = ValueOf(layer, feature, key); !text.empty()) return text;
    }
    return "";
  }

  /// Takes a street's name, if it has one, with its longest stretch; returns whether the geometry
  /// was followed for that.
  bool TakeStreet(const Layer& layer, Feature* feature, protozero::data_view geometry) {
    std::optional<int> rank;
    for (const std::string_view key : kKindKeys) {
      if (!rank) rank = RankOfStreet(layer.name, ValueOf(layer, *feature, key));
    }
    const std::string_view text = rank ? NameOf(layer, *feature) : "";
    if (text.empty()) return false;
    Follow(layer, geometry, feature);
    for (const auto& part : feature->parts) {
      const auto along = LongestStretch(part);
      if (!along) continue;
      GroundShapes::Street& street = streets_[std::string(text)];
      if (along->Length() > street.along.Length()) street = {*along, *rank, std::string(text)};
    }
    return true;
  }

  void TakeName(const Layer& layer, Feature* feature, protozero::data_view geometry) {
    if (!NamesPlaces(layer.name)) return;
    const std::string_view text = NameOf(layer, *feature);
    for (const std::string_view key : kKindKeys) {
      const auto rank = RankOf(ValueOf(layer, *feature, key));
      if (!rank || text.empty()) continue;
      Follow(layer, geometry, feature);
      if (feature->parts.empty()) return;
      const auto [x, y] = std::pair(feature->parts[0][0], feature->parts[0][1]);
      // One that lies beside the tile is in the tile where it lies.
      if (std::min(x, y) < 0 || std::max(x, y) >= kTileUnits) return;
      shapes_.names.push_back({x, y, *rank, std::string(text)});
      return;
    }
  }

  /// The commands of a geometry: move, draw and close. The first point of a part is a move.
  void Follow(const Layer& layer, protozero::data_view geometry, Feature* feature) {
    const auto in_units = [&](std::int64_t at) {
      const std::int64_t units = at * kTileUnits / layer.extent;
      // Far beyond the tile nothing is seen.
      return static_cast<std::int32_t>(std::clamp<std::int64_t>(units, -1 << 20, 1 << 20));
    };
    const char* data = geometry.data();
    const char* const end = data + geometry.size();
    std::int64_t x = 0, y = 0;
    while (data != end) {
      const auto command = static_cast<std::uint32_t>(protozero::decode_varint(&data, end));
      const std::uint32_t id = command & 7u, n = command >> 3;
      if (id == kClosePath) continue;  // what covers is closed anyhow
      if (id != kMoveTo && id != kLineTo) throw protozero::exception();
      for (std::uint32_t i = 0; i < n; ++i) {
        x += protozero::decode_zigzag32(
            static_cast<std::uint32_t>(protozero::decode_varint(&data, end)));
        y += protozero::decode_zigzag32(
            static_cast<std::uint32_t>(protozero::decode_varint(&data, end)));
        if (++places_ > kMostPlaces) throw protozero::exception();
        if (id == kMoveTo || feature->parts.empty()) feature->parts.emplace_back();
        const std::int32_t at[] = {in_units(x), in_units(y)};
        std::vector<std::int32_t>& part = feature->parts.back();
        const std::size_t size = part.size();
        if (size > 0 && part[size - 2] == at[0] && part[size - 1] == at[1]) continue;
        part.insert(part.end(), std::begin(at), std::end(at));
      }
    }
  }

  GroundShapes shapes_;
  std::map<std::string, GroundShapes::Street> streets_;  // by name
  std::size_t places_ = 0;
};

}  // namespace

std::optional<GroundShapes> ReadVectorTile(const std::string& bytes) {
  try {
    return Reader().Take(bytes);
  } catch (const protozero::exception&) {
    return {};
  }
}

}  // namespace muster::tools
