// SPDX-License-Identifier: Apache-2.0
// Zarr and N5: a letter for the format (2, 3, 5), the metadata up to a byte of 0, attributes of the group around it up
// to another, and bytes that are all chunks.
#include <algorithm>
#include <fstream>

#include "io/volume/zarr.h"
#include "memory_file.h"
#include "quench/context.h"
#include "shape/sample_type.h"

namespace {

void put(const std::filesystem::path& file, std::string_view bytes) {
  std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// The part up to a byte of 0, which is taken off.
std::string_view part_of(std::string_view& rest) {
  const std::string_view part = rest.substr(0, rest.find('\0'));
  rest.remove_prefix(std::min(part.size() + 1, rest.size()));
  return part;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quench;
  namespace fs = std::filesystem;
  static const fs::path folder = [] {
    const fs::path base = fs::exists("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path();
    return base / ("quench-fuzz-" + std::to_string(getpid()) + ".zarr");
  }();
  if (size == 0) return 0;
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  const char format = rest[0];
  rest.remove_prefix(1);
  const std::string_view metadata = part_of(rest), attributes = part_of(rest);
  fs::remove_all(folder);
  const fs::path array = folder / "0";
  for (const char* inside : {"0/0", "c/0/0"}) fs::create_directories(array / inside);
  put(array / (format == '2' ? ".zarray" : format == '3' ? "zarr.json" : "attributes.json"), metadata);
  if (!attributes.empty()) {
    put(folder / ".zgroup", "{}");
    put(folder / ".zattrs", attributes);
  }
  for (const char* chunk : {"0.0.0", "0/0/0", "0/0/1", "c/0/0/0"}) put(array / chunk, rest);
  fuzz::reads_or_refuses(
      [&] {
        Context context;
        context.memory_limit = 1 << 20;
        const SliceStream stream = io::open_zarr(array, {}, &context);
        const auto& dims = stream.grid.dims;
        if (*std::min_element(dims.begin(), dims.end()) < 1) fuzz::defect("a side of the volume is not positive");
        if (!stream.grid.spacing.allFinite() || stream.grid.spacing.minCoeff() <= 0)
          fuzz::defect("the spacing is not positive");
        std::vector<std::byte> slice(static_cast<std::size_t>(dims[0] * dims[1]) * shape::size_of(stream.type));
        constexpr std::int64_t enough = 20;
        for (std::int64_t z = 0; z < std::min(dims[2], enough); ++z) stream.next(slice);
      },
      true);
  return 0;
}
