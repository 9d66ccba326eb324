#pragma once

#include <string>

#include "base/object_reader.h"
#include "model/scenario.h"

namespace muster {

/// The name of the road file in the key "roads": the file stands beside the scenario's.
std::string ReadRoadFileName(const ObjectReader& roads);

/// All of the key "roads" but the roads. Throws InputError.
ScenarioRoads ReadRoadsKey(const ObjectReader& roads);

/// The key "air". Throws InputError.
ScenarioAir ReadAir(const ObjectReader& air);

}  // namespace muster
