# SPDX-License-Identifier: Apache-2.0
# Libraries that have no module of CMake everywhere, or one that asks for more than is needed (FindHDF5: the language C;
# Debian's files of GDCM: what they name beside it). They are found by their names, when Quench is built and again, from
# quench-config.cmake, on the machine that uses it: nothing that is installed names a file of the machine that built it.
#   quench_find_library(NAME [SUFFIXES folder...] LIBRARIES names...)
# defines the target quench::NAME and the variables quench_NAME_FOUND and quench_NAME_LIBRARIES (files). Of each item of
# LIBRARIES, names separated by commas, the first name that is found is taken; all items must be.
function(quench_find_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SUFFIXES;LIBRARIES")
  set(files "")
  set(found ON)
  foreach(names ${arg_LIBRARIES})
    string(REPLACE "," ";" names ${names})
    list(GET names 0 first)
    find_library(QUENCH_LIBRARY_${first} NAMES ${names} PATH_SUFFIXES ${arg_SUFFIXES})
    mark_as_advanced(QUENCH_LIBRARY_${first})
    if(QUENCH_LIBRARY_${first})
      list(APPEND files ${QUENCH_LIBRARY_${first}})
    else()
      set(found OFF)
    endif()
  endforeach()
  if(found AND NOT TARGET quench::${name})
    add_library(quench::${name} INTERFACE IMPORTED)
    set_target_properties(quench::${name} PROPERTIES INTERFACE_LINK_LIBRARIES "${files}")
  endif()
  set(quench_${name}_FOUND ${found} PARENT_SCOPE)
  set(quench_${name}_LIBRARIES ${files} PARENT_SCOPE)
endfunction()

# By the name of one of them.
macro(quench_find_known_library name)
  if(${name} STREQUAL "hdf5")
    quench_find_library(hdf5 SUFFIXES hdf5/serial LIBRARIES hdf5_serial,hdf5)
  elseif(${name} STREQUAL "gdcm")
    quench_find_library(gdcm LIBRARIES gdcmMSFF gdcmDSED gdcmDICT gdcmCommon)
  else()
    quench_find_library(${name} LIBRARIES ${name})
  endif()
endmacro()
