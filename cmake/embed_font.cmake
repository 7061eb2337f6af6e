# SPDX-License-Identifier: Apache-2.0
# A file as C++ source: cmake -DFONT=FILE -DSOURCE=FILE -P embed_font.cmake. String literals compile far faster than
# numbers; they are short, as compilers limit them.
file(READ ${FONT} bytes HEX)
string(LENGTH "${bytes}" digits)
math(EXPR size "${digits} / 2")
string(REGEX REPLACE "(..)" "\\\\x\\1" bytes "${bytes}")
string(LENGTH "${bytes}" length)
set(literals "")
set(piece 16384)
foreach(begin RANGE 0 ${length} ${piece})
  string(SUBSTRING "${bytes}" ${begin} ${piece} part)
  string(APPEND literals "    \"${part}\"\n")
endforeach()
file(WRITE ${SOURCE} "// Made by embed_font.cmake.
#include \"picture/font.h\"

namespace quench::picture {

std::string_view font_file() {
  static const char bytes[] =
${literals};
  return {bytes, ${size}};
}

}  // namespace quench::picture
")
