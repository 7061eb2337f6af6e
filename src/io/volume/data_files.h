// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "io/volume/stored_volume.h"

/// Files that a header names for its samples: NRRD and MetaImage have the same syntax.
namespace quench::io {

inline constexpr std::size_t kMostDataFiles = 100'000;

/// The files in the value of `field` in the header `file` of an image of `axes` axes: a name, "LIST [axes of each]"
/// (then the names are `list`), or "pattern first last step [axes of each]" with one %d of printf (also %03d). Names
/// are relative to the folder of the header. The files need not exist. Throws Error(input) for anything else.
std::vector<SampleBlock> named_data_files(const std::filesystem::path& file, const std::string& value,
                                          const std::vector<std::string>& list, std::size_t axes, const char* field);

/// 0 for what is not a regular file or does not exist.
std::uint64_t size_of_file(const std::filesystem::path& file);

/// The position in a file after `lines` lines from `begin` on; its end where it has fewer.
std::uint64_t after_lines(const std::filesystem::path& file, std::uint64_t begin, std::int64_t lines);

/// The position `bytes` before the end of a file; beyond its end where it is shorter, so that nothing can be read
/// there.
std::uint64_t before_the_end(const std::filesystem::path& file, std::uint64_t bytes);

}  // namespace quench::io
