#pragma once

#include <string>

#include "tools/report/coast.h"

namespace muster::tools {

/// A binned file of GSHHG (netCDF), as Debian's gmt-gshhg packages have it, read through libnetcdf
/// where that is installed: loaded when asked for, so nothing links it. The grid reads a bin when
/// it is asked for one. Throws InputError saying what to install when the library or the file is
/// missing, or what is wrong with the file.
ShoreGrid OpenGshhg(const std::string& file);

/// The finest of Debian's files on this machine; "" when there is none.
std::string InstalledGshhg();

/// What a page says of the coast: of `choice`, which is "none", "auto" (the finest file installed)
/// or a file. Null without one, and without an origin. What is missing for "auto" is put into
/// `missing`, in words.
nlohmann::ordered_json CoastOf(const std::string& choice, const Scenario& scenario,
                               std::string* missing);

}  // namespace muster::tools
