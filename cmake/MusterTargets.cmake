# muster_options: what every target of ours compiles with. Warnings and sanitizers hang here.
add_library(muster_options INTERFACE)
target_compile_features(muster_options INTERFACE cxx_std_20)
target_link_libraries(muster_options INTERFACE fmt::fmt)
target_include_directories(muster_options INTERFACE "${PROJECT_SOURCE_DIR}")
target_compile_options(muster_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
                                                -ffp-contract=off -pthread)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # False alarms about std::string at -O3, GCC bug 105651.
  target_compile_options(muster_options INTERFACE -Wno-restrict)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  # The compiler tidies its memory from 1 GB on, not at every 100 MB: a quarter less time.
  target_compile_options(muster_options INTERFACE "SHELL:--param ggc-min-heapsize=1000000")
endif()
if(MUSTER_WERROR)
  target_compile_options(muster_options INTERFACE -Werror)
endif()
if(MUSTER_SANITIZE)
  target_compile_options(muster_options INTERFACE -fsanitize=${MUSTER_SANITIZE}
                                                  -fno-omit-frame-pointer)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # Its sanitizers make it see uninitialised members inside std::regex that are not there.
    target_compile_options(muster_options INTERFACE -fno-sanitize-recover=all
                                                    -Wno-maybe-uninitialized)
  endif()
  target_link_options(muster_options INTERFACE -fsanitize=${MUSTER_SANITIZE})
endif()
if(MUSTER_FUZZ)
  target_compile_options(muster_options INTERFACE -fsanitize=fuzzer-no-link)
endif()

# What nearly every file includes, parsed once. Each file names what it uses all the same: the
# sanitizers' presets build without it.
file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/precompiled.cc" CONTENT "")
add_library(muster_precompiled STATIC "${PROJECT_BINARY_DIR}/precompiled.cc")
target_link_libraries(muster_precompiled PRIVATE muster_options nlohmann_json::nlohmann_json)
target_precompile_headers(muster_precompiled PRIVATE
  <algorithm> <chrono> <cmath> <filesystem> <fstream> <functional> <map> <memory> <mutex> <optional>
  <set> <span> <string> <string_view> <thread> <tuple> <utility> <variant> <vector> <fmt/format.h>
  <nlohmann/json.hpp>)

# The same for tests, with the test framework. They are compiled with less optimisation, for half
# the time: what they call is not.
if(BUILD_TESTING)
  add_library(muster_precompiled_tests STATIC "${PROJECT_BINARY_DIR}/precompiled.cc")
  target_link_libraries(muster_precompiled_tests
                        PRIVATE muster_options GTest::gtest nlohmann_json::nlohmann_json)
  target_compile_options(muster_precompiled_tests PRIVATE -Og)
  target_precompile_headers(muster_precompiled_tests PRIVATE
    $<TARGET_PROPERTY:muster_precompiled,PRECOMPILE_HEADERS> <gtest/gtest.h>)
endif()

# muster_library(NAME SOURCES ... [PUBLIC ...] [PRIVATE ...]): library muster_NAME, alias
# muster::NAME; static unless BUILD_SHARED_LIBS.
function(muster_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(muster_${name} ${ARG_SOURCES})
  add_library(muster::${name} ALIAS muster_${name})
  target_link_libraries(muster_${name} PUBLIC "$<BUILD_INTERFACE:muster_options>"
                        ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  target_precompile_headers(muster_${name} REUSE_FROM muster_precompiled)
endfunction()

# muster_program(NAME SOURCES ... LINK ...): executable NAME.
function(muster_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE muster_options ${ARG_LINK})
  target_precompile_headers(${name} REUSE_FROM muster_precompiled)
endfunction()

# muster_test(NAME LABEL label [HAS_LONG] [MANY_CASES FILTER] SOURCES ... LINK ...): GoogleTest program
# NAME, every case a CTest test with that label. With HAS_LONG the cases of suites named Long... have the
# label slow. With MANY_CASES those that the filter names run once more, labelled slow, with many draws
# (tests/cases.h).
function(muster_test name)
  cmake_parse_arguments(ARG "HAS_LONG" "LABEL;TIMEOUT;MANY_CASES" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE muster_options ${ARG_LINK} GTest::gtest GTest::gtest_main)
  target_compile_options(${name} PRIVATE -Og)
  target_precompile_headers(${name} REUSE_FROM muster_precompiled_tests)
  # Fewer together than in the programs: what tests of one folder are called is often the same.
  set_target_properties(${name} PROPERTIES UNITY_BUILD_BATCH_SIZE 24)
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  if(MUSTER_SANITIZE)
    math(EXPR ARG_TIMEOUT "10 * ${ARG_TIMEOUT}")
  endif()
  set(short)
  if(ARG_HAS_LONG)
    set(short TEST_FILTER "-Long*:*/Long*")
    gtest_discover_tests(${name} TEST_FILTER "Long*:*/Long*" DISCOVERY_TIMEOUT 60 NO_PRETTY_VALUES
                         PROPERTIES LABELS slow TIMEOUT 14400)
  endif()
  if(ARG_MANY_CASES)
    add_test(NAME ManyCases.${name} COMMAND ${name} "--gtest_filter=${ARG_MANY_CASES}")
    set_tests_properties(ManyCases.${name} PROPERTIES
      LABELS slow TIMEOUT 14400 ENVIRONMENT MUSTER_MANY_CASES=1)
  endif()
  # Names alone: the value of a parameter may be an address.
  gtest_discover_tests(${name} ${short} DISCOVERY_TIMEOUT 60 NO_PRETTY_VALUES
                       PROPERTIES LABELS "${ARG_LABEL}" TIMEOUT ${ARG_TIMEOUT})
endfunction()
