// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "io/tree/tree_samples.h"
#include "quench/error.h"

namespace quench::io {

bool is_tree_file(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  return extension == ".swc" || extension == ".rsml";
}

Tree read_tree(const std::filesystem::path& file, bool* axes_known, Context* context) {
  if (!is_tree_file(file))
    throw Error(ErrorCode::usage,
                fmt::format("'{}' is not a tree by its extension; trees are .swc and .rsml", file.string()));
  const bool swc = lower_extension(file) == ".swc";
  Tree tree = swc ? read_swc(load_file(file, context), context) : read_rsml(load_file(file, context), context);
  if (axes_known) *axes_known = !swc;
  return tree;
}

}  // namespace quench::io
