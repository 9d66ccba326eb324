#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace muster::tools {

/// Runs `ogr2ogr` (GDAL, Debian's package gdal-bin) on a file and hands on its features, each as
/// one line of GeoJSON. `layer`: what it reads of the file, with options of ogr2ogr. Throws
/// InputError when there is no such program, and when it finds an error in the file; `expected`
/// says what the file should hold.
void ReadByOgr(const std::string& file, const std::vector<std::string>& layer,
               std::string_view expected, const std::function<void(std::string_view)>& take);

}  // namespace muster::tools
