# Compiler settings shared by every target of this project. Only the standard is public.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

add_library(srmp_flags INTERFACE)
target_compile_options(
  srmp_flags INTERFACE -Wall -Wextra -Wno-unused-parameter
                       -ffp-contract=off  # the same bits whether or not the CPU has fma
)
if(SKBUILD)
  # Assertions name their source files; in a wheel without the directories of the machine that built it. Of several
  # that match the last counts, and the innermost is wanted.
  set(prefixes ${SRMP_PYPI_PREFIXES} ${PROJECT_SOURCE_DIR})
  list(REVERSE prefixes)
  foreach(prefix IN LISTS prefixes)
    add_compile_options(-ffile-prefix-map=${prefix}/=)
  endforeach()
endif()
if(SRMP_SANITIZE)
  add_compile_options(-fsanitize=${SRMP_SANITIZE} -fno-omit-frame-pointer -g)
  add_link_options(-fsanitize=${SRMP_SANITIZE})
  # Pinocchio and Coal come without sanitizers. Under ASan Eigen would pad its blocks by hand in our code and not in
  # theirs, and whoever frees the other's memory crashes; malloc aligns to 16 bytes anyway.
  add_compile_definitions(EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()
