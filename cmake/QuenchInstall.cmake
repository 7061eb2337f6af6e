# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` puts where, in three components: program (with manual pages, completion and the schema of
# reports), development (library, headers, quench.pc, find_package(quench CONFIG) -> quench::quench) and documentation.
include(CMakePackageConfigHelpers)

if(QUENCH_PROGRAM)
  install(TARGETS quench_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
  if(QUENCH_SHELL_FILES)
    # Where distributions keep the completion of zsh elsewhere (Debian: share/zsh/vendor-completions).
    set(QUENCH_ZSH_DIR ${CMAKE_INSTALL_DATADIR}/zsh/site-functions CACHE STRING "Where zsh finds completion")
    install(DIRECTORY ${QUENCH_SHELL_FILES}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT program)
    install(FILES ${QUENCH_SHELL_FILES}/bash/quench DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
            COMPONENT program)
    install(FILES ${QUENCH_SHELL_FILES}/zsh/_quench DESTINATION ${QUENCH_ZSH_DIR} COMPONENT program)
    install(FILES ${QUENCH_SHELL_FILES}/fish/quench.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d
            COMPONENT program)
  endif()
  # What other programs load: modules of 3D Slicer, plug-ins of ParaView and Blender, which look for the program from here.
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/plugins/slicer/modules/ DESTINATION ${CMAKE_INSTALL_DATADIR}/quench/slicer
          COMPONENT program USE_SOURCE_PERMISSIONS)
  install(FILES ${PROJECT_SOURCE_DIR}/plugins/paraview/quench_paraview.py ${PROJECT_SOURCE_DIR}/plugins/paraview/load_quench.py
                ${PROJECT_SOURCE_DIR}/plugins/paraview/show_core.py
          DESTINATION ${CMAKE_INSTALL_DATADIR}/quench/paraview COMPONENT program)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/plugins/blender/quench_blender DESTINATION ${CMAKE_INSTALL_DATADIR}/quench/blender
          COMPONENT program PATTERN __pycache__ EXCLUDE)
  install(FILES ${PROJECT_SOURCE_DIR}/plugins/fiji/Quench_Skeleton.ijm ${PROJECT_SOURCE_DIR}/plugins/fiji/Quench_Thickness.ijm
          DESTINATION ${CMAKE_INSTALL_DATADIR}/quench/fiji COMPONENT program)
  install(FILES ${PROJECT_SOURCE_DIR}/plugins/meshlab/select_thin.mlx DESTINATION ${CMAKE_INSTALL_DATADIR}/quench/meshlab
          COMPONENT program)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/plugins/qgis/quench_processing DESTINATION ${CMAKE_INSTALL_DATADIR}/quench/qgis
          COMPONENT program PATTERN __pycache__ EXCLUDE)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/plugins/napari DESTINATION ${CMAKE_INSTALL_DATADIR}/quench
          COMPONENT program PATTERN __pycache__ EXCLUDE PATTERN test_* EXCLUDE PATTERN README.md EXCLUDE)
  install(FILES ${PROJECT_SOURCE_DIR}/docs/report.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/quench COMPONENT program)
endif()
if(QUENCH_MPI)
  install(TARGETS quench_mpi RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
endif()

install(TARGETS quench EXPORT quench-targets
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/quench DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
install(EXPORT quench-targets NAMESPACE quench:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/quench COMPONENT development)
get_target_property(QUENCH_LIBRARY_TYPE quench TYPE)
set(QUENCH_NEEDS_DEPENDENCIES OFF)
if(QUENCH_LIBRARY_TYPE STREQUAL "STATIC_LIBRARY")
  set(QUENCH_NEEDS_DEPENDENCIES ON)
endif()
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/quench-config.cmake.in ${PROJECT_BINARY_DIR}/quench-config.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/quench)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/quench-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/quench-config.cmake ${PROJECT_BINARY_DIR}/quench-config-version.cmake
              ${PROJECT_SOURCE_DIR}/cmake/quench-libraries.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/quench COMPONENT development)
include(QuenchPkgConfig)

# The licence, and the guide with all that its pages show and link to (tests/consumer follows every link), in the folders they have in the sources.
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md
              ${PROJECT_SOURCE_DIR}/CITATION.cff ${PROJECT_SOURCE_DIR}/CONTRIBUTING.md
        DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT documentation)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs/user ${PROJECT_SOURCE_DIR}/docs/tutorials ${PROJECT_SOURCE_DIR}/docs/algorithms
                  ${PROJECT_SOURCE_DIR}/docs/figures ${PROJECT_SOURCE_DIR}/docs/pictures
        DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs COMPONENT documentation
        FILES_MATCHING PATTERN "*.md" PATTERN "*.svg" PATTERN "*.png" PATTERN "__pycache__" EXCLUDE)
foreach(name architecture dissertation gallery glossary peers testing)
  install(FILES ${PROJECT_SOURCE_DIR}/docs/${name}.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs COMPONENT documentation)
endforeach()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/notes DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT documentation
        FILES_MATCHING PATTERN "*.md" PATTERN "*.png")
install(FILES ${PROJECT_SOURCE_DIR}/viewer/FORMAT.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/viewer COMPONENT documentation)
foreach(name paraview slicer blender fiji napari meshlab qgis)  # other_programs.md links to them
  install(FILES ${PROJECT_SOURCE_DIR}/plugins/${name}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/plugins/${name}
          COMPONENT documentation)
endforeach()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT documentation
        PATTERN "CMakeLists.txt" EXCLUDE PATTERN "__pycache__" EXCLUDE)
