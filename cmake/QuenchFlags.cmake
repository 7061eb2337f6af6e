# SPDX-License-Identifier: Apache-2.0
# Warnings and sanitizers of every Quench target.
function(quench_flags target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Woverloaded-virtual)
  if(QUENCH_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
  if(QUENCH_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${QUENCH_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(${target} PUBLIC -fsanitize=${QUENCH_SANITIZE})
  endif()
endfunction()
