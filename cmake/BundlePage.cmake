# cmake -DOUT=FILE.cc -DSOURCE=DIR -DWORK=DIR -DESBUILD=... -DTHREE=... -P BundlePage.cmake
# Writes OUT: PageTemplate() and SceneScript() of tools/report/page.h, the page of SOURCE with its script
# and its style in it, and the script of its scene in 3D with three.js (THREE: its module, "" without).

# bundle(FILE OUTPUT_VARIABLE OPTION...)
function(bundle file output)
  execute_process(
    COMMAND "${ESBUILD}" "${SOURCE}/${file}" --bundle --minify --log-level=warning
            --target=chrome110,firefox115,safari16.4 "--outfile=${WORK}/${file}" ${ARGN}
    COMMAND_ERROR_IS_FATAL ANY)
  file(READ "${WORK}/${file}" text)
  set(${output} "${text}" PARENT_SCOPE)
endfunction()

# bytes(FILE ARRAY_VARIABLE SIZE_VARIABLE): a file as the numbers of an array.
function(bytes file array size)
  file(READ "${file}" hex HEX)
  string(LENGTH "${hex}" digits)
  math(EXPR n "${digits} / 2")
  string(REGEX REPLACE "(..)" "0x\\1," numbers "${hex}")
  set(${array} "${numbers}" PARENT_SCOPE)
  set(${size} "${n}" PARENT_SCOPE)
endfunction()

# Letters of all languages as they are: as escapes they would be twice as long.
bundle(main.js script --format=iife --charset=utf8)
string(REPLACE "</script" "<\\/script" script "${script}")
bundle(style.css style)
file(READ "${SOURCE}/index.html" page)
string(REPLACE "/*STYLE*/" "${style}" page "${page}")
string(REPLACE "/*SCRIPT*/" "${script}" page "${page}")
file(WRITE "${WORK}/page.html" "${page}")
bytes("${WORK}/page.html" page_bytes page_size)

set(scene_bytes "0")
set(scene_size 0)
if(THREE)
  bundle(scene/index.js scene --format=iife --global-name=musterScene "--alias:three=${THREE}"
    "--banner:js=/*! with three.js r111, copyright 2010-2019 three.js authors, MIT license (https://threejs.org/license) */")
  bytes("${WORK}/scene/index.js" scene_bytes scene_size)
endif()

file(CONFIGURE OUTPUT "${OUT}" @ONLY CONTENT [=[
#include <string_view>

#include "tools/report/page.h"

namespace muster::tools {
namespace {
constexpr unsigned char kPage[] = {@page_bytes@};
constexpr unsigned char kScene[] = {@scene_bytes@};
}  // namespace

std::string_view PageTemplate() { return {reinterpret_cast<const char*>(kPage), @page_size@}; }
std::string_view SceneScript() { return {reinterpret_cast<const char*>(kScene), @scene_size@}; }

}  // namespace muster::tools
]=])
