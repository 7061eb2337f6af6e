# SPDX-License-Identifier: Apache-2.0
# Warnings and sanitizers of every Quench target.
function(quench_flags target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Woverloaded-virtual)
  if(QUENCH_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")  # collects its garbage later: a tenth of the time of compiling
    target_compile_options(${target} PRIVATE --param=ggc-min-heapsize=524288)
  endif()
  if(QUENCH_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${QUENCH_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=${QUENCH_SANITIZE})
  endif()
endfunction()

# Headers that are slow to read, read once per target. -DQUENCH_PCH=OFF shows a missing #include.
function(quench_precompile target)
  if(QUENCH_PCH)
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

# For what only calls the library: half the time of compiling, no difference when it runs.
function(quench_compile_quickly target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# For tests that hardly compute anything themselves: -Og of GCC takes two thirds of the time of -O1.
function(quench_compile_sooner target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:$<IF:$<CXX_COMPILER_ID:GNU>,-Og,-O1>>)
endfunction()
