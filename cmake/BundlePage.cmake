# cmake -DOUT=FILE.cc -DSOURCE=DIR -DWORK=DIR -DESBUILD=... -P BundlePage.cmake
# Writes OUT: PageTemplate() of tools/report/page.h, the page of SOURCE with its script and its style
# in it.

# bundle(FILE OUTPUT_VARIABLE OPTION...)
function(bundle file output)
  execute_process(
    COMMAND "${ESBUILD}" "${SOURCE}/${file}" --bundle --minify --log-level=warning
            --target=chrome110,firefox115,safari16.4 "--outfile=${WORK}/${file}" ${ARGN}
    COMMAND_ERROR_IS_FATAL ANY)
  file(READ "${WORK}/${file}" text)
  set(${output} "${text}" PARENT_SCOPE)
endfunction()

bundle(main.js script --format=iife)
string(REPLACE "</script" "<\\/script" script "${script}")
bundle(style.css style)
file(READ "${SOURCE}/index.html" page)
string(REPLACE "/*STYLE*/" "${style}" page "${page}")
string(REPLACE "/*SCRIPT*/" "${script}" page "${page}")
file(WRITE "${WORK}/page.html" "${page}")

file(READ "${WORK}/page.html" hex HEX)
string(LENGTH "${hex}" digits)
math(EXPR size "${digits} / 2")
string(REGEX REPLACE "(..)" "0x\\1," array "${hex}")
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
