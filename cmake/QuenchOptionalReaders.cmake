# SPDX-License-Identifier: Apache-2.0
# Optional libraries of single formats; without them a sentence says what is missing.
# QUENCH_WITH_ASSIMP, QUENCH_WITH_TIFF and QUENCH_WITH_JPEG tell the installed package what a static library needs.
set(QUENCH_WITH_ASSIMP OFF)
set(QUENCH_WITH_TIFF OFF)
set(QUENCH_WITH_JPEG OFF)
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

if(QUENCH_JPEG)
  find_package(JPEG QUIET)
  if(JPEG_FOUND)
    target_link_libraries(quench PRIVATE JPEG::JPEG)
    set(QUENCH_WITH_JPEG ON)
    target_compile_definitions(quench PRIVATE QUENCH_HAS_JPEG)
  else()
    message(STATUS "libjpeg not found: JPEG images will not be read")
  endif()
endif()

# The others by their names; see quench-libraries.cmake, which is installed, too. QUENCH_FOREIGN: those that are used.
include(${CMAKE_CURRENT_LIST_DIR}/quench-libraries.cmake)
set(QUENCH_FOREIGN "")
function(quench_foreign_library option name header loss)  # and the folders of headers; sets QUENCH_WITH_<option>
  set(QUENCH_WITH_${option} OFF PARENT_SCOPE)
  if(NOT QUENCH_${option})
    return()
  endif()
  find_path(QUENCH_${option}_INCLUDE ${header} PATH_SUFFIXES ${ARGN})
  mark_as_advanced(QUENCH_${option}_INCLUDE)
  quench_find_known_library(${name})
  if(QUENCH_${option}_INCLUDE AND quench_${name}_FOUND)
    target_link_libraries(quench PRIVATE quench::${name})
    set(QUENCH_WITH_${option} ON PARENT_SCOPE)
    set(QUENCH_FOREIGN ${QUENCH_FOREIGN} ${name} PARENT_SCOPE)
    set(quench_${name}_LIBRARIES ${quench_${name}_LIBRARIES} PARENT_SCOPE)
  else()
    message(STATUS "lib${name} not found: ${loss} will not be read")
  endif()
endfunction()

quench_foreign_library(ZSTD zstd zstd.h "chunks of Zarr and N5 that it packs")
quench_foreign_library(BLOSC blosc blosc.h "chunks of Zarr and N5 that it packs")
foreach(name ZSTD BLOSC)
  if(QUENCH_WITH_${name})
    target_include_directories(quench PRIVATE ${QUENCH_${name}_INCLUDE})
    target_compile_definitions(quench PRIVATE QUENCH_HAS_${name})
  endif()
endforeach()

# Readers of HDF5 and DICOM: sources of their own, apart from the rooms that are compiled in one go.
function(quench_foreign_reader name)  # and the sources
  foreach(file ${ARGN})
    set_source_files_properties(${PROJECT_SOURCE_DIR}/src/io/volume/${file} PROPERTIES
                                COMPILE_DEFINITIONS QUENCH_HAS_${name} COMPILE_OPTIONS "-isystem;${QUENCH_${name}_INCLUDE}"
                                SKIP_UNITY_BUILD_INCLUSION ON SKIP_PRECOMPILE_HEADERS ON)
  endforeach()
endfunction()

quench_foreign_library(HDF5 hdf5 hdf5.h "volumes in HDF5" hdf5/serial)
if(QUENCH_WITH_HDF5)
  quench_foreign_reader(HDF5 hdf5.cpp hdf5_spacing.cpp)
endif()
quench_foreign_library(GDCM gdcm gdcmImageReader.h "series of DICOM" gdcm-3.0)
if(QUENCH_WITH_GDCM)
  quench_foreign_reader(GDCM dicom.cpp dicom_file.cpp)
endif()

# Both take milliseconds to load: programs that read no volumes do not.
include(CheckLinkerFlag)
check_linker_flag(CXX LINKER:--as-needed QUENCH_HAS_AS_NEEDED)
if(QUENCH_HAS_AS_NEEDED)
  target_link_options(quench INTERFACE LINKER:--as-needed)
endif()
