# SPDX-License-Identifier: Apache-2.0
# quench.pc, which finds its folders from its own place. A shared library needs Eigen's headers only; a static one all that
# it was built with, and as there is no other then, not only with `pkg-config --static`.
block()
set(requires eigen3)
set(libraries "")
if(QUENCH_NEEDS_DEPENDENCIES)
  list(APPEND requires tbb fmt zlib pugixml freetype2)
  foreach(pair ASSIMP:assimp TIFF:libtiff-4 JPEG:libjpeg)
    string(REPLACE ":" ";" pair ${pair})
    list(GET pair 0 name)
    list(GET pair 1 package)
    if(QUENCH_WITH_${name})
      list(APPEND requires ${package})
    endif()
  endforeach()
  set(files "")
  foreach(name ${QUENCH_FOREIGN})
    list(APPEND files ${quench_${name}_LIBRARIES})
  endforeach()
  foreach(file ${files})
    get_filename_component(folder ${file} DIRECTORY)
    get_filename_component(name ${file} NAME_WE)
    string(REGEX REPLACE "^lib" "-l" name ${name})
    if(NOT folder IN_LIST CMAKE_CXX_IMPLICIT_LINK_DIRECTORIES)
      list(APPEND libraries -L${folder})
    endif()
    list(APPEND libraries ${name})
  endforeach()
endif()
list(JOIN requires " " requires)
list(JOIN libraries " " libraries)
if(libraries AND QUENCH_HAS_AS_NEEDED)
  string(PREPEND libraries " -Wl,--as-needed ")
elseif(libraries)
  string(PREPEND libraries " ")
endif()
if(IS_ABSOLUTE ${CMAKE_INSTALL_LIBDIR} OR IS_ABSOLUTE ${CMAKE_INSTALL_INCLUDEDIR})
  set(prefix ${CMAKE_INSTALL_PREFIX})
  set(libdir ${CMAKE_INSTALL_FULL_LIBDIR})
  set(includedir ${CMAKE_INSTALL_FULL_INCLUDEDIR})
else()
  file(RELATIVE_PATH up /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
  string(REGEX REPLACE "/$" "" up ${up})
  set(prefix "\${pcfiledir}/${up}")
  set(libdir "\${prefix}/${CMAKE_INSTALL_LIBDIR}")
  set(includedir "\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}")
endif()
file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/quench.pc @ONLY CONTENT [[
prefix=@prefix@
libdir=@libdir@
includedir=@includedir@

Name: quench
Description: @PROJECT_DESCRIPTION@
Version: @PROJECT_VERSION@
Requires: @requires@
Libs: -L${libdir} -lquench@libraries@
Cflags: -I${includedir}
]])
install(FILES ${PROJECT_BINARY_DIR}/quench.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)
endblock()
