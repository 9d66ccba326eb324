#pragma once

#include <string>

#include "tools/files/run_directory.h"
#include "tools/launch/hosts.h"

namespace muster::tools {

/// Throws InputError where a folder of this host holds something.
void CheckSecondFolder(const std::string& folder);

/// Puts what `muster resume` needs beside the log into the second log's folder, unless that is
/// there: the manifest, keys and orders of the run directory. `host`: where the folder is; nullptr:
/// here. Throws InputError where it holds another run, and SystemError.
void FillSecondFolder(const RunDirectory& run, const std::string& folder, const Host* host);

}  // namespace muster::tools
