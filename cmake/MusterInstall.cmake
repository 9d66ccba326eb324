# What `cmake --install` puts where. Component muster: what runs missions. Component dev: what a
# policy or a process in a project of its own is built with.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(data_dir "${CMAKE_INSTALL_DATADIR}/muster")
add_custom_target(installed DEPENDS muster muster_python_types)  # all that is, without the tests
install(TARGETS muster muster-world muster-uav muster-worker muster-vehicle muster-scheduler
  muster-recorder RUNTIME COMPONENT muster)
install(DIRECTORY scenarios DESTINATION "${data_dir}" COMPONENT muster)
install(DIRECTORY lcmtypes/types/ DESTINATION "${data_dir}/lcmtypes" COMPONENT muster
  FILES_MATCHING PATTERN "*.lcm")
install(FILES README.md DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT muster)
install(FILES LICENSE DESTINATION "${CMAKE_INSTALL_DOCDIR}" RENAME copyright COMPONENT muster)
install(DIRECTORY docs/ DESTINATION "${CMAKE_INSTALL_DOCDIR}/docs" COMPONENT muster
  FILES_MATCHING PATTERN "*.md")
install(DIRECTORY examples DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT muster
  USE_SOURCE_PERMISSIONS)

# Manual pages, from each command's own --help.
find_program(HELP2MAN help2man)
if(HELP2MAN)
  message(STATUS "Manual pages: made with help2man when installing")
  set(man_dir "${CMAKE_INSTALL_MANDIR}/man1")
  install(CODE "execute_process(
    COMMAND \"${PROJECT_SOURCE_DIR}/cmake/make-man-pages\" \"${HELP2MAN}\"
      \"${CMAKE_RUNTIME_OUTPUT_DIRECTORY}\"
      \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${man_dir}\"
    COMMAND_ERROR_IS_FATAL ANY)" COMPONENT muster)
else()
  message(STATUS "Manual pages: off, help2man is missing (Debian: apt-get install help2man)")
endif()

install(FILES tools/cli/completion.bash RENAME muster COMPONENT muster
  DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions")
# Debian's zsh looks into the second below /usr, and into the first below /usr/local.
foreach(folder site-functions vendor-completions)
  install(FILES tools/cli/completion.zsh RENAME _muster COMPONENT muster
    DESTINATION "${CMAKE_INSTALL_DATADIR}/zsh/${folder}")
endforeach()

# Python: module muster, for any Python 3. Debian's own looks into dist-packages.
set(MUSTER_PYTHON_DIR "lib/python3/dist-packages" CACHE STRING
  "Where the Python module goes, below the prefix")
install(DIRECTORY "${MUSTER_PYTHON_TYPES}/muster" DESTINATION "${MUSTER_PYTHON_DIR}"
  COMPONENT muster FILES_MATCHING PATTERN "*.py")

# For lcm-spy, which takes every jar in the CLASSPATH.
find_program(JAVAC javac)
find_program(JAR jar)
find_file(LCM_JAR lcm.jar PATHS /usr/share/java /usr/local/share/java)
if(JAVAC AND JAR AND LCM_JAR)
  message(STATUS "Types for lcm-spy: compiled with ${JAVAC} when installing")
  install(CODE "execute_process(
    COMMAND \"${PROJECT_SOURCE_DIR}/cmake/make-types-jar\" \"${LCM_GEN}\" \"${JAVAC}\" \"${JAR}\"
      \"${LCM_JAR}\" \"${PROJECT_SOURCE_DIR}/lcmtypes/types\"
      \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/java/muster-types.jar\"
    COMMAND_ERROR_IS_FATAL ANY)" COMPONENT muster)
else()
  message(STATUS "Types for lcm-spy: off, a JDK or lcm.jar is missing (Debian: default-jdk-headless, liblcm-java)")
endif()

# Libraries and headers.
set(libraries base program words model types bus protocol scheduler solver policies scheduler_process
  agents)
set(pc_libraries "")
foreach(library IN LISTS libraries)
  set_target_properties(muster_${library} PROPERTIES EXPORT_NAME ${library})
  get_target_property(type muster_${library} TYPE)
  if(type STREQUAL STATIC_LIBRARY)
    set(pc_libraries "-lmuster_${library} ${pc_libraries}")
  endif()
endforeach()
list(TRANSFORM libraries PREPEND muster_)
# The same numbers from the same expressions there, too.
target_compile_features(muster_base INTERFACE cxx_std_20)
target_compile_options(muster_base INTERFACE "$<INSTALL_INTERFACE:-ffp-contract=off>")
set(header_dir "${CMAKE_INSTALL_INCLUDEDIR}/muster")
install(TARGETS ${libraries} EXPORT MusterTargets
  ARCHIVE COMPONENT dev
  INCLUDES DESTINATION "${header_dir}")
install(DIRECTORY base model lcmtypes protocol scheduler agents DESTINATION "${header_dir}"
  COMPONENT dev FILES_MATCHING PATTERN "*.h")
install(DIRECTORY "${MUSTER_GENERATED_TYPES}/muster" DESTINATION "${header_dir}" COMPONENT dev)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/Muster")
install(EXPORT MusterTargets NAMESPACE muster:: DESTINATION "${package_dir}" COMPONENT dev)
configure_package_config_file(cmake/MusterConfig.cmake.in "${PROJECT_BINARY_DIR}/MusterConfig.cmake"
  INSTALL_DESTINATION "${package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/MusterConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/MusterConfig.cmake"
  "${PROJECT_BINARY_DIR}/MusterConfigVersion.cmake" cmake/FindLcm.cmake cmake/FindSodium.cmake
  DESTINATION "${package_dir}" COMPONENT dev)
file(RELATIVE_PATH up "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
configure_file(cmake/muster.pc.in "${PROJECT_BINARY_DIR}/muster.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/muster.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig"
  COMPONENT dev)

# Debian packages: scripts/package.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME muster)
set(CPACK_PACKAGE_CONTACT "Muster <muster@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL muster dev)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_MUSTER_PACKAGE_NAME muster)
set(CPACK_DEBIAN_MUSTER_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_MUSTER_PACKAGE_DEPENDS liblcm-bin)
set(CPACK_DEBIAN_MUSTER_PACKAGE_RECOMMENDS "gnuplot-nox, python3")
set(CPACK_COMPONENT_MUSTER_DESCRIPTION
  "disaster-response sensing missions over LCM\nRuns missions of UAVs, vehicles and workers as processes that talk over LCM,\nrecords, audits, explains and replays them.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME muster-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION devel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
  "muster (= ${PROJECT_VERSION}), liblcm-dev, liblcm-bin, libglib2.0-dev, libfmt-dev, libsodium-dev, pkg-config")
set(CPACK_COMPONENT_DEV_DESCRIPTION
  "libraries and headers for policies and processes of Muster missions\nStatic libraries, headers, CMake package and pkg-config file.")
include(CPack)
