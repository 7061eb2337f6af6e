# SPDX-License-Identifier: Apache-2.0
# Optional libraries of single formats; without them a sentence says what is missing.
# QUENCH_WITH_ASSIMP and QUENCH_WITH_TIFF tell the installed package what a static library needs.
set(QUENCH_WITH_ASSIMP OFF)
set(QUENCH_WITH_TIFF OFF)
if(QUENCH_ASSIMP)
  find_package(assimp QUIET)
  if(assimp_FOUND)
    target_sources(quench PRIVATE ${PROJECT_SOURCE_DIR}/src/io/mesh/assimp_mesh.cpp)
    target_link_libraries(quench PRIVATE assimp::assimp)
    set(QUENCH_WITH_ASSIMP ON)
    target_compile_definitions(quench PRIVATE QUENCH_HAS_ASSIMP)
  else()
    message(STATUS "Assimp not found: meshes will be read from PLY, OBJ, OFF and STL only")
  endif()
endif()

if(QUENCH_TIFF)
  find_package(TIFF 4.5 QUIET)  # before, libtiff has handlers of messages for the whole process only
  if(TIFF_FOUND)
    target_link_libraries(quench PRIVATE TIFF::TIFF)
    set(QUENCH_WITH_TIFF ON)
    target_compile_definitions(quench PRIVATE QUENCH_HAS_TIFF)
  else()
    message(STATUS "libtiff 4.5 or newer not found: TIFF stacks will not be read")
  endif()
endif()
