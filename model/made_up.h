#pragma once

#include <cstdint>
#include <vector>

#include "base/random.h"
#include "model/roads.h"
#include "model/zone.h"

namespace muster {

/// Streets at right angles, `n` by `n` junctions about `block_m` apart, moved a little; some
/// streets are missing, bend, are one-way, are for people only, or for vehicles only. `plain`:
/// nothing of that.
Roads StreetGrid(int n, double block_m, std::uint64_t seed, bool plain = false);

/// Zones drawn in a square of that extent: stars (concave), triangles, some with a hole, touching
/// and overlapping as it comes. Corners in whole millimetres.
std::vector<Zone> DrawnZones(Random* random, double extent_m, int n);

}  // namespace muster
