# SPDX-License-Identifier: Apache-2.0
# The letters of pictures: FreeType draws them, and the font is built into the library, so that pictures look the same
# on every machine. Debian: libfreetype-dev and fonts-dejavu-core.
find_package(Freetype REQUIRED)
find_file(QUENCH_FONT DejaVuSans.ttf
          PATHS /usr/share/fonts /usr/local/share/fonts PATH_SUFFIXES truetype/dejavu dejavu dejavu-sans-fonts TTF truetype
          DOC "Font of the letters in pictures, built into the library")
mark_as_advanced(QUENCH_FONT)
if(NOT QUENCH_FONT)
  message(FATAL_ERROR "DejaVuSans.ttf not found: install fonts-dejavu-core (other systems: dejavu-sans-fonts, ttf-dejavu), or name a TrueType font with -DQUENCH_FONT=FILE")
endif()

set(embedded ${PROJECT_BINARY_DIR}/font_file.cpp)
add_custom_command(OUTPUT ${embedded}
                   COMMAND ${CMAKE_COMMAND} -DFONT=${QUENCH_FONT} -DSOURCE=${embedded} -P ${PROJECT_SOURCE_DIR}/cmake/embed_font.cmake
                   DEPENDS ${QUENCH_FONT} ${PROJECT_SOURCE_DIR}/cmake/embed_font.cmake
                   COMMENT "Embedding the font of pictures" VERBATIM)
target_sources(quench PRIVATE ${embedded})
set_source_files_properties(${embedded} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
# Its headers are for one file only.
set_source_files_properties(${PROJECT_SOURCE_DIR}/src/picture/canvas.cpp PROPERTIES INCLUDE_DIRECTORIES "${FREETYPE_INCLUDE_DIRS}")
target_link_libraries(quench PRIVATE $<LINK_ONLY:Freetype::Freetype>)
