# Finds C++ packages that were installed with pip.
#
# PyPI packages built with cmeel have their headers, libraries and CMake configs in <site-packages>/cmeel.prefix; others
# (ruckig) have them in <site-packages>. Both directories are put first in CMAKE_PREFIX_PATH, for the Python that CMake
# finds: that of the active virtual environment, or of pip's build environment, whose directories are known from sys.path
# only. SRMP_SITE_PACKAGES names another directory in which pip installed them: none of these packages depends on the
# version of Python, so builds for several Pythons can share them. Sets SRMP_CMEEL_PREFIX, the directory of cmeel packages.

set(Python_FIND_VIRTUALENV FIRST)
find_package(Python 3.10 REQUIRED COMPONENTS Interpreter OPTIONAL_COMPONENTS Development.Module)

set(SRMP_SITE_PACKAGES "" CACHE PATH "Where pip installed the C++ packages; default: what the Python has on its path")
if(SRMP_SITE_PACKAGES)
  set(SRMP_SYS_PATH ${SRMP_SITE_PACKAGES})
else()
  execute_process(
    COMMAND ${Python_EXECUTABLE} -c "import sys; print(';'.join(p for p in sys.path if p))"
    OUTPUT_VARIABLE SRMP_SYS_PATH OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
endif()
set(SRMP_CMEEL_PREFIX "")
foreach(site IN LISTS SRMP_SYS_PATH)
  if(EXISTS ${site}/cmeel.prefix/lib/cmake/pinocchio)
    set(SRMP_CMEEL_PREFIX ${site}/cmeel.prefix)
    break()
  endif()
endforeach()
if(NOT SRMP_CMEEL_PREFIX)
  message(FATAL_ERROR "No cmeel.prefix directory with Pinocchio in it is in ${SRMP_SYS_PATH}. Install the build requirements "
                      "into the Python at ${Python_EXECUTABLE} first: pip install --group build")
endif()

# Packages without cmeel use lib or lib64, depending on the machine on which they were built.
set(SRMP_PYPI_PREFIXES ${SRMP_CMEEL_PREFIX})
foreach(site IN LISTS SRMP_SYS_PATH)
  if(EXISTS ${site}/lib64/cmake OR EXISTS ${site}/lib/cmake)
    list(APPEND SRMP_PYPI_PREFIXES ${site} ${site}/lib64/cmake)
  endif()
endforeach()
list(PREPEND CMAKE_PREFIX_PATH ${SRMP_PYPI_PREFIXES})

set(CMAKE_POLICY_DEFAULT_CMP0167 NEW)  # use Boost's own CMake package, also for Pinocchio and Coal
