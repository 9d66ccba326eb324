# Run by each build: cmake -DOUT=FILE.cc -DSOURCE=DIR -DWORK=DIR -DNODE=... -DNPM=... -DPROBLEM=... -P
# BundlePage.cmake
# Writes OUT (PageTemplate() of tools/report/page.h) when it would change: the bundled page, or ""
# and why. A bundle that could not be made is tried again by the next build.

# write_template(TEXT_OF_ARRAY SIZE)
function(write_template array size)
  file(CONFIGURE OUTPUT "${OUT}" @ONLY CONTENT [=[
#include <string_view>

#include "tools/report/page.h"

namespace muster::tools {
namespace {
constexpr unsigned char kPage[] = {@array@};
}  // namespace

std::string_view PageTemplate() { return {reinterpret_cast<const char*>(kPage), @size@}; }

}  // namespace muster::tools
]=])
endfunction()

function(without_page why)
  message("Report pages are off: ${why}")
  write_template("0" 0)
endfunction()

if(PROBLEM)
  without_page("${PROBLEM}")
  return()
endif()

file(GLOB sources RELATIVE "${SOURCE}" "${SOURCE}/src/*")
list(APPEND sources package.json package-lock.json .npmrc build.mjs)
set(all "")
foreach(source IN LISTS sources)
  file(SHA256 "${SOURCE}/${source}" hash)
  string(APPEND all "${source} ${hash}\n")
endforeach()
set(made "")
if(EXISTS "${WORK}/made")
  file(READ "${WORK}/made" made)
endif()
if(made STREQUAL all AND EXISTS "${OUT}")
  return()
endif()

file(REMOVE "${WORK}/made")
file(REMOVE_RECURSE "${WORK}/src")
foreach(source IN LISTS sources)
  get_filename_component(folder "${source}" DIRECTORY)
  file(COPY "${SOURCE}/${source}" DESTINATION "${WORK}/${folder}")
endforeach()
file(SHA256 "${WORK}/package-lock.json" lock)
set(installed "")
if(EXISTS "${WORK}/node_modules/.muster")
  file(READ "${WORK}/node_modules/.muster" installed)
endif()
if(NOT installed STREQUAL lock)
  message("Fetching the report page's libraries with npm")
  execute_process(
    COMMAND "${NPM}" ci --ignore-scripts --no-audit --no-fund --prefer-offline --fetch-retries=1
    WORKING_DIRECTORY "${WORK}" RESULT_VARIABLE failed
    OUTPUT_FILE "${WORK}/npm.log" ERROR_FILE "${WORK}/npm.log")
  if(failed)
    without_page("npm could not fetch the page's libraries (${WORK}/npm.log)")
    return()
  endif()
  file(WRITE "${WORK}/node_modules/.muster" "${lock}")
endif()
execute_process(COMMAND "${NODE}" build.mjs "${WORK}/page.html" WORKING_DIRECTORY "${WORK}"
                RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "the report page cannot be bundled (above)")
endif()
file(READ "${WORK}/page.html" hex HEX)
string(LENGTH "${hex}" digits)
math(EXPR size "${digits} / 2")
string(REGEX REPLACE "(..)" "0x\\1," array "${hex}")
write_template("${array}" "${size}")
file(WRITE "${WORK}/made" "${all}")
