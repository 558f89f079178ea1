# Finds the C++ packages that were installed with pip.
#
# PyPI packages made with cmeel put headers, libraries and CMake configs under <site-packages>/cmeel.prefix; others
# (ruckig) straight under <site-packages>. Both are added to CMAKE_PREFIX_PATH for the Python that CMake finds first.
# After include: SRMP_CMEEL_PREFIX holds the folder.

find_package(Python 3.10 REQUIRED COMPONENTS Interpreter OPTIONAL_COMPONENTS Development.Module)

execute_process(
  COMMAND ${Python_EXECUTABLE} -c
          "import sys, pathlib\nfor p in sys.path:\n    if (pathlib.Path(p) / 'cmeel.prefix').is_dir(): print(p); break"
  OUTPUT_VARIABLE SRMP_SITE_PACKAGES OUTPUT_STRIP_TRAILING_WHITESPACE)
if(NOT SRMP_SITE_PACKAGES)
  message(FATAL_ERROR "The Python at ${Python_EXECUTABLE} has no cmeel.prefix folder. Install the build requirements "
                      "there first: pip install --group dev (or see [build-system] in pyproject.toml).")
endif()
set(SRMP_CMEEL_PREFIX ${SRMP_SITE_PACKAGES}/cmeel.prefix)
list(APPEND CMAKE_PREFIX_PATH ${SRMP_CMEEL_PREFIX} ${SRMP_SITE_PACKAGES} ${SRMP_SITE_PACKAGES}/lib64/cmake)
