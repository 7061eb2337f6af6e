// SPDX-License-Identifier: Apache-2.0
// A reader of volumes: QUENCH_FUZZ_READER names it, or QUENCH_FUZZ_EXTENSION a format whose headers say where the
// samples are; QUENCH_FUZZ_PICTURE a reader of pictures, QUENCH_FUZZ_STREAM one of slices. With QUENCH_FUZZ_PNG the
// checksums are made right first: they would hide everything behind them.
#include "io/volume/slice_streams.h"
#include "io/volume/stored_volume.h"
#include "io/volume/volume_formats.h"
#include "memory_file.h"
#include "quench/context.h"
#include "small_files.h"

#ifndef QUENCH_FUZZ_EXTENSION
#define QUENCH_FUZZ_EXTENSION ".bin"
#endif
#ifdef QUENCH_FUZZ_PICTURE
#define QUENCH_FUZZ_READER read_values
namespace quench::io {
static Volume read_values(const std::filesystem::path& file, Context* context) {
  return volume_of(QUENCH_FUZZ_PICTURE(file, context), file, {}, context);
}
}  // namespace quench::io
#endif
#ifdef QUENCH_FUZZ_STREAM
#define QUENCH_FUZZ_READER read_slice_stream
namespace quench::io {
static Volume read_slice_stream(const std::filesystem::path& file, Context* context) {
  return read_stream(QUENCH_FUZZ_STREAM(file, context), file, context);
}
}  // namespace quench::io
#endif
#ifndef QUENCH_FUZZ_READER
#define QUENCH_FUZZ_READER read_stored
namespace quench::io {
static Volume read_stored(const std::filesystem::path& file, Context* context) {
  return read_stream(open_stored(file, context), file, context);
}
}  // namespace quench::io
#endif

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace quench;
  static const fuzz::MemoryFile file(QUENCH_FUZZ_EXTENSION);
#ifdef QUENCH_FUZZ_PNG
  std::string mended(reinterpret_cast<const char*>(data), size);
  small_files::mend_checksums(mended);
  data = reinterpret_cast<const std::uint8_t*>(mended.data());
#endif
  fuzz::reads_or_refuses(
      [&] {
        Context context;
        context.memory_limit = 1 << 24;  // an honest file may be much larger when it is read; such take too long here
        const Volume volume = io::QUENCH_FUZZ_READER(file.holding(data, size), &context);
        std::uint64_t count = 1;
        for (const std::int64_t side : volume.grid.dims) {
          if (side < 1) fuzz::defect("a side of the volume is not positive");
          count *= static_cast<std::uint64_t>(side);
        }
        if (std::visit([](const auto& samples) { return samples.size(); }, volume.samples) != count)
          fuzz::defect("the volume has another number of samples than voxels");
      },
      true);
  return 0;
}
