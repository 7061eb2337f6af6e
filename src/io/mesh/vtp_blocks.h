// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace quench::io {

/// How a VTK XML file stores the bytes of an array: with headers of 4 or 8 bytes, whole or as zlib blocks.
///
/// Whole: [bytes][data]. Blocks: [number of blocks][bytes of a block][bytes of the last one, 0 if full][compressed
/// bytes of each block...][blocks...]. In base64, the header of compressed data is an own padded run.
struct BlockFormat {
  bool wide_headers = false;
  bool compressed = false;
  bool base64 = false;
};

/// The bytes of the array that `stored` begins with. Throws Error(input) with the sentence "`what` ..." when they are
/// incomplete or damaged; allocates no more than `stored` can hold.
std::string decode_blocks(std::string_view stored, const BlockFormat& format, const std::string& what);

/// Compressed blocks with 8-byte headers; the same bytes for any number of threads.
std::string encode_blocks(std::string_view bytes);

}  // namespace quench::io
