# Installs the library, its headers and the CMake package `srmp`.
#
# In a wheel everything lies under <site-packages>/srmp, and the libraries of other wheels are found relative to that:
# no path of the build machine is left. In a plain `cmake --install` the run path is where the libraries were linked from.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

if(SKBUILD)
  set(SRMP_LIB_DIR lib)
  set(SRMP_INCLUDE_DIR include)
  set(SRMP_DATA_DIR data)
  set_target_properties(srmp PROPERTIES INSTALL_RPATH "$ORIGIN/../../cmeel.prefix/lib")
else()
  set(SRMP_LIB_DIR ${CMAKE_INSTALL_LIBDIR})
  set(SRMP_INCLUDE_DIR ${CMAKE_INSTALL_INCLUDEDIR})
  set(SRMP_DATA_DIR ${CMAKE_INSTALL_DATADIR}/srmp)
  set_target_properties(srmp PROPERTIES INSTALL_RPATH_USE_LINK_PATH ON)
endif()
set(SRMP_CMAKE_DIR ${SRMP_LIB_DIR}/cmake/srmp)

# A symbol that no library has is an error now, not in the user's process.
if(NOT SRMP_SANITIZE)
  target_link_options(srmp PRIVATE $<$<PLATFORM_ID:Linux>:LINKER:-z,defs>)
endif()
# Symbols of the static libraries inside (ruckig) stay inside: another copy may live in the same process.
target_link_options(srmp PRIVATE $<$<PLATFORM_ID:Linux>:LINKER:--exclude-libs,ALL>)
# Wheels cannot hold the symbolic links of a versioned soname.
if(NOT SKBUILD)
  set_target_properties(srmp PROPERTIES VERSION ${PROJECT_VERSION}
                                        SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
endif()
set_source_files_properties(${PROJECT_SOURCE_DIR}/src/srmp/core/version.cpp TARGET_DIRECTORY srmp
                            PROPERTIES COMPILE_DEFINITIONS SRMP_VERSION="${PROJECT_VERSION}")

install(TARGETS srmp EXPORT srmpTargets
        LIBRARY DESTINATION ${SRMP_LIB_DIR}
        FILE_SET HEADERS DESTINATION ${SRMP_INCLUDE_DIR})
if(NOT SKBUILD)  # a wheel has them as part of the Python package
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/python/srmp/data/ DESTINATION ${SRMP_DATA_DIR})
endif()
install(EXPORT srmpTargets NAMESPACE srmp:: DESTINATION ${SRMP_CMAKE_DIR})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/srmpConfig.cmake.in ${PROJECT_BINARY_DIR}/srmpConfig.cmake
                              INSTALL_DESTINATION ${SRMP_CMAKE_DIR} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/srmpConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/srmpConfig.cmake ${PROJECT_BINARY_DIR}/srmpConfigVersion.cmake
        DESTINATION ${SRMP_CMAKE_DIR})
