# Learned policies are trained with libtorch where it is there; using a trained model needs none.
# Read from the root: what it finds is known in the folder that asks, and below.
set(MUSTER_LEARNED AUTO CACHE STRING
  "Build muster-train, which needs libtorch: AUTO (where it is there), ON or OFF")
set_property(CACHE MUSTER_LEARNED PROPERTY STRINGS AUTO ON OFF)
if(NOT MUSTER_LEARNED STREQUAL OFF AND NOT MUSTER_SANITIZE)
  set(packages "libtorch-dev libopenblas0-pthread")
  find_package(Torch QUIET)
  if(Torch_FOUND)
    message(STATUS "muster train: with libtorch ${Torch_VERSION}")
  elseif(MUSTER_LEARNED STREQUAL ON)
    message(FATAL_ERROR "MUSTER_LEARNED=ON, and libtorch is missing: apt-get install ${packages}")
  else()
    message(STATUS "muster train: off, libtorch is missing (Debian: apt-get install ${packages})")
  endif()
endif()
