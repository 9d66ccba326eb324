#pragma once

#include <optional>
#include <string_view>

#include "tools/tiles/vector_tile.h"

namespace muster::tools {

/// What a layer's areas or lines of that kind are drawn as; none: they are not drawn. `kind` is
/// what the tile's schema calls class or kind.
std::optional<GroundClass> ClassOf(std::string_view layer, std::string_view kind, bool is_area);

/// How important the name of a street of that kind is: 6 a main road, 7 a street, 8 a path; none:
/// the layer's lines name no streets, or it is no street.
std::optional<int> RankOfStreet(std::string_view layer, std::string_view kind);

/// Whether the layer's points are names of places.
bool NamesPlaces(std::string_view layer);
/// How important a place is: 0 a city, to 5 a part of a village; none: it is not named.
std::optional<int> RankOf(std::string_view kind);

}  // namespace muster::tools
