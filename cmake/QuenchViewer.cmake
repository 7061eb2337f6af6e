# SPDX-License-Identifier: Apache-2.0
# The interactive page (viewer/) is bundled into one HTML file and built into the library, where the program or the
# Python module is built. That needs Node.js and npm; without them all is complete but for pages. QUENCH_WITH_VIEWER
# tells which.
set(QUENCH_VIEWER AUTO CACHE STRING "Build the interactive page into the library: ON, OFF or AUTO (if npm is there)")
set_property(CACHE QUENCH_VIEWER PROPERTY STRINGS AUTO ON OFF)
set(QUENCH_WITH_VIEWER OFF)

# Sets QUENCH_WITH_VIEWER, or `reason`.
function(quench_prepare_viewer reason)
  set(viewer ${PROJECT_SOURCE_DIR}/viewer)
  if(NOT EXISTS ${viewer}/package.json OR NOT EXISTS ${viewer}/build.mjs)
    set(${reason} "viewer/ is not complete" PARENT_SCOPE)
    return()
  endif()
  find_program(QUENCH_NODE NAMES node nodejs)
  find_program(QUENCH_NPM NAMES npm)
  mark_as_advanced(QUENCH_NODE QUENCH_NPM)
  if(NOT QUENCH_NODE OR NOT QUENCH_NPM)
    set(${reason} "Node.js and npm not found" PARENT_SCOPE)
    return()
  endif()
  execute_process(COMMAND ${QUENCH_NODE} --version OUTPUT_VARIABLE version OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  string(REGEX REPLACE "^v" "" version "${version}")
  if(version VERSION_LESS 18)
    set(${reason} "Node.js ${version} is older than 18" PARENT_SCOPE)
    return()
  endif()
  # npm is asked only when the packages that lie there are not those of the lock file; a new lock file configures anew.
  set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${viewer}/package-lock.json)
  set(check ${QUENCH_NODE} ${PROJECT_SOURCE_DIR}/cmake/viewer_packages.mjs ${viewer})
  execute_process(COMMAND ${check} RESULT_VARIABLE differs)
  if(differs)
    message(STATUS "Installing the npm packages of the interactive page")
    execute_process(COMMAND ${QUENCH_NPM} ci --ignore-scripts --prefer-offline --fetch-retries=1 --no-audit --no-fund --loglevel=error
                    WORKING_DIRECTORY ${viewer} RESULT_VARIABLE failed OUTPUT_QUIET)
    if(NOT failed)
      execute_process(COMMAND ${check} RESULT_VARIABLE failed)
    endif()
    if(failed)
      set(${reason} "npm could not install the packages of viewer/package-lock.json" PARENT_SCOPE)
      return()
    endif()
  endif()
  set(QUENCH_WITH_VIEWER ON PARENT_SCOPE)
endfunction()

if(QUENCH_VIEWER AND (QUENCH_PROGRAM OR QUENCH_WITH_PYTHON))
  quench_prepare_viewer(QUENCH_NO_VIEWER_REASON)
  if(NOT QUENCH_WITH_VIEWER)
    set(QUENCH_NO_VIEWER_TEXT "${QUENCH_NO_VIEWER_REASON}: the program is built without interactive pages of results")
    if(QUENCH_VIEWER STREQUAL "AUTO")
      message(STATUS "${QUENCH_NO_VIEWER_TEXT}")
    else()
      message(FATAL_ERROR "QUENCH_VIEWER is ${QUENCH_VIEWER}, but ${QUENCH_NO_VIEWER_REASON}")
    endif()
  endif()
endif()

# Adds the page to a target as a source that defines quench::pipeline::page_program().
function(quench_page_source target)
  set(viewer ${PROJECT_SOURCE_DIR}/viewer)
  set(folder ${PROJECT_BINARY_DIR}/viewer)
  set(embedded ${folder}/page_program.cpp)
  if(QUENCH_WITH_VIEWER)
    file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${viewer}/src/*)
    add_custom_command(OUTPUT ${folder}/page.html
                       COMMAND ${QUENCH_NODE} build.mjs ${folder}/page.html
                       WORKING_DIRECTORY ${viewer}
                       DEPENDS ${sources} ${viewer}/build.mjs ${viewer}/package.json ${viewer}/package-lock.json
                       COMMENT "Bundling the interactive page" VERBATIM)
    add_custom_command(OUTPUT ${embedded}
                       COMMAND ${QUENCH_NODE} ${PROJECT_SOURCE_DIR}/cmake/embed_page.mjs ${folder}/page.html ${embedded}
                       DEPENDS ${folder}/page.html ${PROJECT_SOURCE_DIR}/cmake/embed_page.mjs
                       COMMENT "Embedding the interactive page" VERBATIM)
  else()
    set(embedded ${folder}/no_page_program.cpp)  # of another name: else it would be newer than what it is made of
    file(CONFIGURE OUTPUT ${embedded} @ONLY CONTENT
         "#include \"pipeline/page_program.h\"\nnamespace quench::pipeline {\nstd::string_view page_program() { return {}; }\n}\n")
  endif()
  target_sources(${target} PRIVATE ${embedded})
  set_source_files_properties(${embedded} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
endfunction()

quench_page_source(quench)
