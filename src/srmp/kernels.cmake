# One source, one object file an instruction set; run time picks. -ffp-contract=off comes with srmp_flags. Other flags than
# the rest of the library has need headers parsed anew. GCC 12 takes its own AVX-512 header for using uninitialised
# values.
set(kernels collision/batch/kernel robot/damped_least_squares search/nearest)
foreach(kernel IN LISTS kernels)
  set_source_files_properties(${kernel}_portable.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)  # their names are short
endforeach()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(avx512 -mavx512f -mavx512dq -mavx512vl -Wno-uninitialized -Wno-maybe-uninitialized)
  foreach(kernel IN LISTS kernels)
    set_source_files_properties(${kernel}_avx2.cpp PROPERTIES COMPILE_OPTIONS "-mavx2" SKIP_PRECOMPILE_HEADERS ON)
    set_source_files_properties(${kernel}_avx512.cpp PROPERTIES COMPILE_OPTIONS "${avx512}" SKIP_PRECOMPILE_HEADERS ON)
  endforeach()
endif()
