#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/moment.h"
#include "model/scenario.h"

namespace muster::tools {

/// One polygon of a file of zones.
struct MapZone {
  enum class Rule { kProhibited, kAuthorisation, kOther };
  std::string id, name;  ///< "": it has none
  Rule rule = Rule::kProhibited;
  double lower_m = 0;                 ///< above the ground; 0 where the file counts from sea level
  std::optional<Moment> from, until;  ///< none: always
  bool recurs = false;                ///< on some days or at some hours of that time only
  std::vector<std::vector<Origin>> rings;  ///< the outline and its holes; of a circle empty
  Origin centre;
  double radius_m = 0;
};

/// The zones of a GeoJSON text, or of one in the European formats ED-269 or ED-318. What GeoJSON
/// alone says is prohibited. Throws InputError.
std::vector<MapZone> ParseZones(std::string_view text, const std::string& file);

struct MapZones {
  std::vector<MapZone> zones;
  std::size_t n_others = 0;  ///< points and lines of a KML file
};

/// The zones of a file: the polygons of .kml and .kmz (Google Earth), read by ogr2ogr, which are
/// all prohibited and whose ids are their names; of all else what ParseZones() says of its text.
/// Throws InputError.
MapZones ReadZones(const std::string& file);

}  // namespace muster::tools
