# SPDX-License-Identifier: Apache-2.0
# find_package(quench CONFIG) -> quench::quench
include(CMakePackageConfigHelpers)
install(TARGETS quench EXPORT quench-targets
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(QUENCH_PROGRAM)
  install(TARGETS quench_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  if(QUENCH_SHELL_FILES)  # where distributions keep the completion of zsh elsewhere: -DQUENCH_ZSH_DIR=
    set(QUENCH_ZSH_DIR ${CMAKE_INSTALL_DATADIR}/zsh/site-functions CACHE STRING "Where zsh finds completion")
    install(DIRECTORY ${QUENCH_SHELL_FILES}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR})
    install(FILES ${QUENCH_SHELL_FILES}/bash/quench DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
    install(FILES ${QUENCH_SHELL_FILES}/zsh/_quench DESTINATION ${QUENCH_ZSH_DIR})
    install(FILES ${QUENCH_SHELL_FILES}/fish/quench.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
  endif()
endif()
if(QUENCH_MPI)
  install(TARGETS quench_mpi RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(FILES ${PROJECT_SOURCE_DIR}/docs/report.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/quench)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/quench DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(EXPORT quench-targets NAMESPACE quench:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/quench)
get_target_property(QUENCH_LIBRARY_TYPE quench TYPE)
set(QUENCH_NEEDS_DEPENDENCIES OFF)
if(QUENCH_LIBRARY_TYPE STREQUAL "STATIC_LIBRARY")
  set(QUENCH_NEEDS_DEPENDENCIES ON)
endif()
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/quench-config.cmake.in ${PROJECT_BINARY_DIR}/quench-config.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/quench)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/quench-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/quench-config.cmake ${PROJECT_BINARY_DIR}/quench-config-version.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/quench)
