# cmake -DOUT=FILE.h -DTYPES="FILE.lcm ..." -P WriteFields.cmake
# Writes OUT: VisitFields(visitor, message...) for each type. It calls the visitor for every field in the
# order of the .lcm file, with that field of each of the messages: visitor(name, field...);
# visitor.Count(name, field...) for a field that counts the elements of an array;
# visitor.Array(name, field..., count...).

cmake_policy(VERSION 3.25)
set(includes "")
set(functions "")
separate_arguments(TYPES UNIX_COMMAND "${TYPES}")
foreach(file ${TYPES})
  file(READ "${file}" text)
  string(REGEX REPLACE "//[^\n]*" "" text "${text}")
  # CMake's lists are split at semicolons, but not inside brackets.
  string(REPLACE "[" "<" text "${text}")
  string(REPLACE "]" ">" text "${text}")
  if(NOT text MATCHES "struct ([a-z0-9_]+)[ \n]*{([^}]*)}")
    message(FATAL_ERROR "${file}: no struct")
  endif()
  set(type "${CMAKE_MATCH_1}")
  string(REGEX REPLACE "[ \n]+" " " body "${CMAKE_MATCH_2}")
  string(REGEX MATCHALL "<[a-z0-9_]+>" counts "${body}")
  set(calls "")
  foreach(field ${body})
    string(STRIP "${field}" field)
    if(field STREQUAL "")
      continue()
    endif()
    if(NOT field MATCHES "^[a-z0-9_]+ ([a-z0-9_<>, ]+)$")
      message(FATAL_ERROR "${file}: cannot read '${field}'")
    endif()
    string(REPLACE "," ";" names "${CMAKE_MATCH_1}")
    foreach(name ${names})
      string(STRIP "${name}" name)
      if(name MATCHES "^([a-z0-9_]+)<([a-z0-9_]+)>$")
        set(call "visitor.Array(\"${CMAKE_MATCH_1}\", message.${CMAKE_MATCH_1}..., message.${CMAKE_MATCH_2}...)")
      elseif("<${name}>" IN_LIST counts)
        set(call "visitor.Count(\"${name}\", message.${name}...)")
      elseif(name MATCHES "^[a-z0-9_]+$")
        set(call "visitor(\"${name}\", message.${name}...)")
      else()
        message(FATAL_ERROR "${file}: cannot read '${name}'")
      endif()
      string(APPEND calls "  ${call};\n")
    endforeach()
  endforeach()
  string(APPEND includes "#include \"muster/${type}.hpp\"\n")
  string(APPEND functions "
template <class Visitor, class... Messages>
  requires(sizeof...(Messages) > 0 && (std::same_as<std::remove_const_t<Messages>, ${type}> && ...))
void VisitFields(Visitor&& visitor, Messages&... message) {
${calls}}
")
endforeach()
file(WRITE "${OUT}" "// Made from the .lcm files by cmake/WriteFields.cmake.
#pragma once

#include <concepts>
#include <type_traits>

${includes}
namespace muster {
${functions}
}  // namespace muster
")
