// SPDX-License-Identifier: Apache-2.0
// The samples of NRRD files, which Quench reads by itself. What ITK says of their header comes from a stand-in here:
// whatever it says, the samples must be read or refused.
#include <algorithm>
#include <cstdio>

#include "io/itk_header.h"
#include "io/volume_formats.h"
#include "memory_file.h"
#include "quench/slices.h"

namespace {

std::string text_of_file;

}  // namespace

namespace quench::io {

std::optional<ItkHeader> itk_header(const std::filesystem::path&, Context*) {
  ItkHeader header;
  const std::size_t sizes = text_of_file.find("sizes: ");
  long long dims[3] = {1, 1, 1};
  if (sizes == std::string::npos ||
      std::sscanf(text_of_file.c_str() + sizes + 7, "%lld %lld %lld", &dims[0], &dims[1], &dims[2]) < 1)
    return {};
  for (std::size_t a = 0; a < 3; ++a) header.grid.dims[a] = dims[a];
  if (text_of_file.find("short") != std::string::npos) {
    header.type = SampleType::uint16;
    header.sample_size = 2;
  }
  if (text_of_file.find("double") != std::string::npos) {
    header.type = SampleType::float64;
    header.sample_size = 8;
  }
  return header;
}

Volume read_itk(const std::filesystem::path&, Context*) { throw Error(ErrorCode::input, "this is no slices"); }

}  // namespace quench::io

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quench;
  static const fuzz::MemoryFile file(".nrrd");
  text_of_file.assign(reinterpret_cast<const char*>(data), size);
  fuzz::reads_or_refuses(
      [&] {
        Context context;
        context.memory_limit = 1 << 22;
        const auto stream = io::open_slices(file.holding(data, size), {}, &context);
        if (!stream) return;
        const auto& dims = stream->grid.dims;
        const std::size_t sample = stream->type == SampleType::float64 ? 8 : stream->type == SampleType::uint16 ? 2 : 1;
        std::vector<std::byte> slice(static_cast<std::size_t>(dims[0] * dims[1]) * sample);
        for (std::int64_t z = 0; z < std::min<std::int64_t>(dims[2], 100); ++z) stream->next(slice);
      },
      true);
  return 0;
}
