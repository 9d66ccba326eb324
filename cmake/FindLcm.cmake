# Debian's LCM has no CMake config and its pkg-config file wants libglib2.0-dev.
find_path(LCM_INCLUDE_DIR lcm/lcm.h)
find_library(LCM_LIBRARY lcm)
find_program(LCM_GEN lcm-gen)
find_package(PkgConfig REQUIRED)
pkg_check_modules(GLIB REQUIRED IMPORTED_TARGET glib-2.0)
pkg_check_modules(LCM QUIET lcm)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Lcm REQUIRED_VARS LCM_LIBRARY LCM_INCLUDE_DIR LCM_GEN)
if(Lcm_FOUND AND NOT TARGET Lcm::Lcm)
  add_library(Lcm::Lcm UNKNOWN IMPORTED)
  set_target_properties(Lcm::Lcm PROPERTIES
    IMPORTED_LOCATION "${LCM_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${LCM_INCLUDE_DIR}")
endif()
