# Installs the library, its headers and the CMake package `srmp`.
#
# In a wheel, everything is installed under <site-packages>/srmp, and libraries of other wheels are found by relative paths,
# so no path of the build machine remains. A plain `cmake --install` keeps the paths of the linked libraries as run path.

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

if(SKBUILD)
  set(SRMP_LIB_DIR lib)
  set(SRMP_INCLUDE_DIR include)
  set(SRMP_DATA_DIR data)
  set_target_properties(srmp PROPERTIES INSTALL_RPATH "${SRMP_ORIGIN}/../../cmeel.prefix/lib")
else()
  set(SRMP_LIB_DIR ${CMAKE_INSTALL_LIBDIR})
  set(SRMP_INCLUDE_DIR ${CMAKE_INSTALL_INCLUDEDIR})
  set(SRMP_DATA_DIR ${CMAKE_INSTALL_DATADIR}/srmp)
  set_target_properties(srmp PROPERTIES INSTALL_RPATH_USE_LINK_PATH ON)
endif()
set(SRMP_CMAKE_DIR ${SRMP_LIB_DIR}/cmake/srmp)

# An undefined symbol is reported when linking, not when a user loads the library.
if(NOT SRMP_SANITIZE)
  target_link_options(srmp PRIVATE $<$<PLATFORM_ID:Linux>:LINKER:-z,defs>)
endif()
# Symbols of static libraries (ruckig) are not exported, because the process may contain another copy of them.
target_link_options(srmp PRIVATE $<$<PLATFORM_ID:Linux>:LINKER:--exclude-libs,ALL>)
# Wheels cannot contain symbolic links, which a versioned soname needs.
if(NOT SKBUILD)
  set_target_properties(srmp PROPERTIES VERSION ${PROJECT_VERSION}
                                        SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
endif()
set_source_files_properties(${PROJECT_SOURCE_DIR}/src/srmp/core/version.cpp TARGET_DIRECTORY srmp
                            PROPERTIES COMPILE_DEFINITIONS SRMP_VERSION="${PROJECT_VERSION}")

install(TARGETS srmp EXPORT srmpTargets
        LIBRARY DESTINATION ${SRMP_LIB_DIR}
        FILE_SET HEADERS DESTINATION ${SRMP_INCLUDE_DIR})
if(NOT SKBUILD)  # in a wheel the data is part of the Python package
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/python/srmp/data/ DESTINATION ${SRMP_DATA_DIR})
endif()
install(EXPORT srmpTargets NAMESPACE srmp:: DESTINATION ${SRMP_CMAKE_DIR})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/srmpConfig.cmake.in ${PROJECT_BINARY_DIR}/srmpConfig.cmake
                              INSTALL_DESTINATION ${SRMP_CMAKE_DIR} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/srmpConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/srmpConfig.cmake ${PROJECT_BINARY_DIR}/srmpConfigVersion.cmake
        DESTINATION ${SRMP_CMAKE_DIR})
