// SPDX-License-Identifier: Apache-2.0
#include "base/deflated.h"

#include <zlib.h>

namespace quench::base {

std::optional<std::string> deflated(std::string_view bytes, int level, int strategy, bool last) {
  z_stream stream{};
  if (deflateInit2(&stream, level, Z_DEFLATED, -15, 9, strategy) != Z_OK) return {};
  std::string out(deflateBound(&stream, static_cast<uLong>(bytes.size())) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int result = deflate(&stream, last ? Z_FINISH : Z_SYNC_FLUSH);
  const bool whole = result == (last ? Z_STREAM_END : Z_OK) && stream.avail_in == 0;
  out.erase(out.size() - stream.avail_out);
  deflateEnd(&stream);
  if (!whole) return {};
  return out;
}

}  // namespace quench::base
