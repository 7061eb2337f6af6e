# SPDX-License-Identifier: Apache-2.0
# Installs Quench into a folder, looks for what belongs there, moves the folder, and builds and runs the consumer against
# it: by find_package() and by pkg-config.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "failed: ${ARGN}")
  endif()
endfunction()
file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/installed)
set(prefix ${WORK}/moved)
file(RENAME ${WORK}/installed ${prefix})

set(belongs ${DOC}/LICENSE ${DOC}/README.md ${DOC}/CHANGELOG.md ${DOC}/docs/user/command_line.md ${DOC}/docs/user/report.md
            include/quench/quench.h ${LIB}/cmake/quench/quench-config.cmake ${LIB}/pkgconfig/quench.pc)
if(PROGRAM)
  list(APPEND belongs bin/quench share/quench/report.schema.json)
  if(SHELL_FILES)
    list(APPEND belongs share/man/man1/quench.1 share/man/man1/quench-run.1 share/bash-completion/completions/quench
                        share/fish/vendor_completions.d/quench.fish)
  endif()
  run(${prefix}/bin/quench --version)
endif()
foreach(file ${belongs})
  if(NOT EXISTS ${prefix}/${file})
    message(FATAL_ERROR "not installed: ${file}")
  endif()
endforeach()

run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/consumer)

find_program(PKG_CONFIG NAMES pkg-config pkgconf)
if(NOT PKG_CONFIG)
  message(STATUS "no pkg-config: quench.pc is not tried")
  return()
endif()
set(ENV{PKG_CONFIG_PATH} ${prefix}/${LIB}/pkgconfig)
run(${PKG_CONFIG} --validate quench)
execute_process(COMMAND ${PKG_CONFIG} --modversion quench OUTPUT_VARIABLE version OUTPUT_STRIP_TRAILING_WHITESPACE)
execute_process(COMMAND ${PKG_CONFIG} --cflags quench OUTPUT_VARIABLE cflags OUTPUT_STRIP_TRAILING_WHITESPACE)
execute_process(COMMAND ${PKG_CONFIG} --libs quench OUTPUT_VARIABLE libs OUTPUT_STRIP_TRAILING_WHITESPACE)
separate_arguments(cflags)
separate_arguments(libs)
run(${CXX} -std=c++20 -O1 "-DPACKAGE_VERSION=\"${version}\"" ${cflags} ${SOURCE}/main.cpp ${SOURCE}/old_names.cpp
    -o ${WORK}/by_pkg_config ${libs})
run(${WORK}/by_pkg_config)
