// SPDX-License-Identifier: Apache-2.0
// A file as C++ source: node embed_page.mjs PAGE.html PAGE.cpp. String literals compile far faster than numbers; they
// are short, as compilers limit them, and a byte has three octal digits, so that no digit after it can join it.
import { readFileSync, writeFileSync } from "node:fs";

const [page, source] = process.argv.slice(2);
const bytes = readFileSync(page);
const kPiece = 8192;
const literal = (piece) => {
  let text = "";
  for (const b of piece)
    text += b === 0x22 || b === 0x5c || b === 0x3f ? `\\${String.fromCharCode(b)}`
      : b >= 0x20 && b < 0x7f ? String.fromCharCode(b)
      : `\\${b.toString(8).padStart(3, "0")}`;
  return `    {"${text}", ${piece.length}},`;
};
const pieces = [];
for (let i = 0; i < bytes.length; i += kPiece) pieces.push(literal(bytes.subarray(i, i + kPiece)));
writeFileSync(source, `// Made by embed_page.mjs.
#include "pipeline/page_program.h"

#include <string>

namespace quench::pipeline {
namespace {

struct Piece {
  const char* text;
  std::size_t size;
};
constexpr Piece kPieces[] = {
${pieces.join("\n")}
};

}  // namespace

std::string_view page_program() {
  static const std::string whole = [] {
    std::string text;
    for (const Piece& piece : kPieces) text.append(piece.text, piece.size);
    return text;
  }();
  return whole;
}

}  // namespace quench::pipeline
`);
