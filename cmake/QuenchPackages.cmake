# SPDX-License-Identifier: Apache-2.0
# Debian packages of what is built: `make packages`, which is `cpack` with this. Four of them, from the components of
# QuenchInstall.cmake: quench, libquench-dev, python3-quench and quench-doc. packaging/debian/finish.cmake adds to each
# what Debian asks for: copyright, changelog, compressed pages, the scripts of Python.
set(QUENCH_MAINTAINER "The Quench developers <developers@quench.invalid>" CACHE STRING "Maintainer in the packages: Name <address>")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "The Quench developers")
set(CPACK_PACKAGE_CONTACT ${QUENCH_MAINTAINER})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each component has its own
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/packaging/debian/finish.cmake)
set(CPACK_QUENCH_SOURCE ${PROJECT_SOURCE_DIR})
set(CPACK_QUENCH_STRIP ${CMAKE_STRIP})
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(about "Quench takes a triangle mesh, a voxel volume, an image or polygons, and
computes the medial axis: exact on voxels, pruned without changing topology,
with erosion thickness, skeletons of sheets and curves, trees and their
traits, and local thickness.

")

set(CPACK_COMPONENTS_ALL program development documentation)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME quench)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "quench-doc, python3-quench, paraview")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "medial axes and skeletons of 3D shapes\n${about}This package has the program, its manual pages and completion.")

# A static library: who links it needs the development files of all that it was built with.
set(depends "libeigen3-dev, libtbb-dev, libfmt-dev, zlib1g-dev, libpugixml-dev, libfreetype-dev")
foreach(pair ASSIMP:libassimp-dev TIFF:libtiff-dev JPEG:libjpeg-dev ZSTD:libzstd-dev BLOSC:libblosc-dev HDF5:libhdf5-dev
             GDCM:libgdcm-dev)
  string(REPLACE ":" ";" pair ${pair})
  list(GET pair 0 option)
  list(GET pair 1 package)
  if(QUENCH_WITH_${option})
    string(APPEND depends ", ${package}")
  endif()
endforeach()
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libquench-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ${depends})
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS "quench-doc, cmake, pkg-config")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "medial axes and skeletons of 3D shapes - C++ library\n${about}This package has the static library, its headers, and its
files for CMake and pkg-config.")

set(CPACK_DEBIAN_DOCUMENTATION_PACKAGE_NAME quench-doc)
set(CPACK_DEBIAN_DOCUMENTATION_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_DOCUMENTATION_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DOCUMENTATION_PACKAGE_SUGGESTS "quench, python3-quench")
set(CPACK_COMPONENT_DOCUMENTATION_DESCRIPTION "medial axes and skeletons of 3D shapes - documentation\n${about}This package has the guide, the pages on algorithms, what was measured
and the examples.")

if(QUENCH_WITH_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
  math(EXPR next "${Python3_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-quench)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "quench-doc, python3-matplotlib, python3-networkx, python3-pandas, python3-scipy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/packaging/debian/postinst ${PROJECT_SOURCE_DIR}/packaging/debian/prerm)
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "medial axes and skeletons of 3D shapes - Python module\n${about}This package has the module for Python 3.")
endif()
include(CPack)
