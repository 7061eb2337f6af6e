// SPDX-License-Identifier: Apache-2.0
// MRC files and CCP4 maps (MRC2014, Cheng et al. 2015, J. Struct. Biol. 192). Lengths are in angstroms.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "io/volume/header_bytes.h"
#include "io/volume/stored_volume.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

constexpr std::size_t kHeaderSize = 1024;

/// Words of four bytes, numbered from 1 as in the definition of the format.
class MrcWords {
 public:
  explicit MrcWords(const std::filesystem::path& file) {
    InputFile in(file);
    std::vector<unsigned char> bytes(kHeaderSize);
    in.stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(kHeaderSize));
    if (!in.stream) refuse_volume(file, "it is shorter than a header; it is damaged or incomplete");
    const unsigned char stamp = bytes[212];
    const bool little = stamp != 0x11, stamped = stamp == 0x44 || stamp == 0x11;
    bytes_ = HeaderBytes(std::move(bytes), little != (std::endian::native == std::endian::little));
    if (stamped || sound()) return;
    bytes_.swap();  // older files have no stamp
    if (!sound()) refuse_volume(file, "it does not begin as an MRC file");
  }
  std::int32_t integer(std::size_t word) const { return bytes_.at<std::int32_t>(4 * (word - 1)); }
  double real(std::size_t word) const { return decimal(bytes_.at<float>(4 * (word - 1))); }
  bool swapped() const { return bytes_.swapped(); }

 private:
  bool sound() const {
    const std::int32_t mode = integer(4), first = integer(17);
    return integer(1) > 0 && mode >= 0 && mode <= 101 && first >= 0 && first <= 3;
  }
  HeaderBytes bytes_;
};

void set_type(const std::filesystem::path& file, const MrcWords& words, StoredVolume& volume) {
  // IMOD wrote unsigned bytes before the standard said that they are signed; its files say which they are.
  constexpr std::int32_t kImod = 1146047817, kBytesAreSigned = 1;
  const bool unsigned_bytes = words.integer(39) == kImod && (words.integer(40) & kBytesAreSigned) == 0;
  switch (words.integer(4)) {
    case 0:
      volume.type.type = unsigned_bytes ? SampleType::uint8 : SampleType::int8;
      return;
    case 1:
      volume.type.type = SampleType::int16;
      return;
    case 2:
      volume.type.type = SampleType::float32;
      return;
    case 6:
      volume.type.type = SampleType::uint16;
      return;
    case 12:
      volume.type = {SampleType::float32, true};
      return;
    case 3:
    case 4:
      refuse_volume(file, "its samples are complex numbers, a transform; convert it to real values");
    default:
      refuse_volume(file,
                    fmt::format("its mode is {}, not 0, 1, 2, 6 or 12; convert it to one of these", words.integer(4)));
  }
}

/// MAPC, MAPR, MAPS: which axis the columns, rows and sections are. All 0 in older files.
std::array<int, 3> axes_of(const std::filesystem::path& file, const MrcWords& words) {
  std::array<int, 3> axes{words.integer(17), words.integer(18), words.integer(19)};
  if (axes == std::array{0, 0, 0}) return {0, 1, 2};
  std::array<int, 3> sorted = axes;
  std::sort(sorted.begin(), sorted.end());
  if (sorted != std::array{1, 2, 3})
    refuse_volume(file, fmt::format("its axes (MAPC, MAPR, MAPS) are {}, {}, {}, not a permutation of 1, 2, 3", axes[0],
                                    axes[1], axes[2]));
  for (int& axis : axes) --axis;
  return axes;
}

void set_grid(const std::filesystem::path& file, const MrcWords& words, StoredVolume& volume) {
  Grid& grid = volume.grid;
  volume.axes = axes_of(file, words);
  Vec3 start = Vec3::Zero();
  for (std::size_t a = 0; a < 3; ++a) {
    grid.dims[static_cast<std::size_t>(volume.axes[a])] = words.integer(1 + a);
    start[volume.axes[a]] = words.integer(5 + a);
  }
  for (std::size_t a = 0; a < 3; ++a)
    if (const double angle = words.real(14 + a); angle != 0 && !(std::abs(angle - 90) <= 1e-3))
      refuse_volume(
          file,
          fmt::format("its cell has the angles {:.6g}, {:.6g} and {:.6g}, but those of a voxel grid are right angles; "
                      "resample it to a rectangular grid",
                      words.real(14), words.real(15), words.real(16)));
  // The cell and its number of intervals; all 0 in files that do not say.
  const Vec3 cell(words.real(11), words.real(12), words.real(13));
  const Vec3 intervals(words.integer(8), words.integer(9), words.integer(10));
  const bool sized = !cell.isZero(0) && !intervals.isZero(0);
  if (sized && !(cell.minCoeff() > 0 && intervals.minCoeff() > 0))
    refuse_volume(file, fmt::format("its cell of {:.6g} x {:.6g} x {:.6g} angstroms in {} x {} x {} intervals does not "
                                    "give the size of a voxel; correct its header",
                                    cell[0], cell[1], cell[2], intervals[0], intervals[1], intervals[2]));
  if (sized) {
    set_steps(file, cell.cwiseQuotient(intervals).asDiagonal(), "cell size", grid);
    volume.spacing_source = "the cell of the header";
    volume.coordinates.units = "angstrom";
  }
  if (const std::int32_t group = words.integer(23);
      group >= 401 && group <= 630 && words.integer(10) > 0 && words.integer(3) > words.integer(10))
    refuse_volume(file, fmt::format("it is a stack of {} volumes; save the one you mean on its own",
                                    words.integer(3) / words.integer(10)));
  // ORIGIN is the position of voxel 0; maps of crystals leave it 0 and count voxels from the origin of the cell.
  const Vec3 origin(words.real(50), words.real(51), words.real(52));
  grid.origin = origin.isZero(0) ? Vec3(grid.direction * start.cwiseProduct(grid.spacing)) : origin;
}

}  // namespace

StoredVolume mrc_header(const std::filesystem::path& file) {
  const MrcWords words(file);
  StoredVolume volume;
  set_type(file, words, volume);
  set_grid(file, words, volume);
  volume.swapped = words.swapped();
  const std::int32_t extended = words.integer(24);
  if (extended < 0) refuse_volume(file, fmt::format("its extended header has {} bytes (NSYMBT)", extended));
  volume.blocks.push_back({file, kHeaderSize + static_cast<std::uint64_t>(extended), 0, {}});
  return volume;
}

}  // namespace quench::io
