# GCC 12 takes its own AVX-512 header for using uninitialised values. One source, one object file an instruction set; run time picks. -ffp-contract=off comes with srmp_flags.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set_source_files_properties(collision/batch/kernel_avx2.cpp PROPERTIES COMPILE_OPTIONS "-mavx2")
  set_source_files_properties(collision/batch/kernel_avx512.cpp PROPERTIES COMPILE_OPTIONS
                                                                           "-mavx512f;-mavx512dq;-mavx512vl;-Wno-uninitialized;-Wno-maybe-uninitialized")
endif()
