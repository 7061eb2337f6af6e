// SPDX-License-Identifier: Apache-2.0
#include "io/common/text_out.h"

#include <iterator>

namespace quench::io {

void TextOut::append(fmt::string_view format, fmt::format_args args) {
  fmt::vformat_to(std::back_inserter(buffer_), format, args);
}

}  // namespace quench::io
