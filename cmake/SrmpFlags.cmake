# Compiler settings of every target of this project. Only the C++ standard is passed on to users of the library.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(APPLE)
  set(SRMP_ORIGIN "@loader_path")  # in run paths: the directory of the library itself
else()
  set(SRMP_ORIGIN "$ORIGIN")
endif()
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

add_library(srmp_flags INTERFACE)
target_compile_options(
  srmp_flags INTERFACE -Wall -Wextra -Wno-unused-parameter
                       -ffp-contract=off  # the same bits whether or not the CPU has fma
)
if(SKBUILD)
  # Assertions contain the names of their source files. A wheel must not contain directories of the machine that built
  # it, so their prefixes are removed. The compiler applies the last prefix that matches, so the longest ones come last.
  set(prefixes ${SRMP_PYPI_PREFIXES} ${PROJECT_SOURCE_DIR})
  list(REVERSE prefixes)
  foreach(prefix IN LISTS prefixes)
    add_compile_options(-ffile-prefix-map=${prefix}/=)
  endforeach()
endif()
if(SRMP_SANITIZE)
  add_compile_options(-fsanitize=${SRMP_SANITIZE} -fno-omit-frame-pointer -g)
  add_link_options(-fsanitize=${SRMP_SANITIZE})
  # Pinocchio and Coal are compiled without sanitizers. With ASan, Eigen would align its blocks by hand in this project's
  # code but not in theirs, so freeing a block across that boundary would crash; malloc aligns to 16 bytes anyway.
  add_compile_definitions(EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()
