# Run by each build: cmake -DOUT=FILE -DSOURCE=DIR -DVERSION=... -P WriteBuildInfo.cmake
# Writes OUT (implementation of tools/host/build_info.h) when it would change.
execute_process(
  COMMAND git -C "${SOURCE}" describe --always --dirty --abbrev=40 --exclude=*
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed OR NOT commit)
  set(commit unknown)
endif()
file(CONFIGURE OUTPUT "${OUT}" @ONLY CONTENT [=[
#include "tools/host/build_info.h"

namespace muster::tools {

const char* const kCommit = "@commit@";
const char* const kVersion = "@VERSION@";
const char* const kLcmVersion = "@LCM@";
const char* const kCompiler = "@COMPILER@";
const char* const kBuildType = "@BUILD_TYPE@";
const char* const kSanitizer = "@SANITIZER@";

}  // namespace muster::tools
]=])
