// SPDX-License-Identifier: Apache-2.0
// Damaged files of every format Quench reads by itself: whatever is done to a small valid file, reading gives valid
// data or one sentence as Error(input), and takes little memory.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <new>
#include <numeric>
#include <random>
#include <set>

#include "full_run.h"
#include "io/common/formats.h"
#include "io/tree/tree_samples.h"
#include "io/volume/slice_streams.h"
#include "io/volume/stored_volume.h"
#include "io/volume/volume_formats.h"
#include "poly_samples.h"
#include "small_files.h"

namespace {

std::size_t largest_allocation = 0;

}  // namespace

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they have their own
[[gnu::noinline]] void* operator new(std::size_t size) {
  largest_allocation = std::max(largest_allocation, size);
  if (void* memory = std::malloc(std::max<std::size_t>(size, 1))) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif

namespace quench {
namespace {

using small_files::SmallFile;
using testing_files::Folder;

/// A file in memory, for readers that take a path: thousands of times faster than files of a disk.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(memfd_create("quench-test", MFD_CLOEXEC)) {}
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(descriptor_); }
  std::filesystem::path holding(const std::string& bytes) const {
    if (ftruncate(descriptor_, 0) != 0 || pwrite(descriptor_, bytes.data(), bytes.size(), 0) < 0) std::abort();
    return "/proc/self/fd/" + std::to_string(descriptor_);
  }

 private:
  int descriptor_;
};

const MemoryFile& memory_file() {
  static const MemoryFile file;
  return file;
}

const Folder& folder() {
  static const Folder made;
  return made;
}

template <Record (*reader)(const io::FileText&)>
void read_poly(const std::string& bytes) {
  reader({"file", bytes}).validate();
}

template <Volume (*reader)(const std::filesystem::path&, Context*)>
void read_samples(const std::string& bytes) {
  const Volume volume = reader(memory_file().holding(bytes), nullptr);
  const auto& dims = volume.grid.dims;
  EXPECT_EQ(std::visit([](const auto& s) { return s.size(); }, volume.samples),
            static_cast<std::size_t>(dims[0] * dims[1] * dims[2]));
}

template <io::Pixels (*reader)(const std::filesystem::path&, Context*)>
void read_pixels(const std::string& bytes) {
  const std::filesystem::path file = memory_file().holding(bytes);
  const Volume image = io::volume_of(reader(file, nullptr), file, {}, nullptr);
  EXPECT_EQ(std::visit([](const auto& s) { return s.size(); }, image.samples),
            static_cast<std::size_t>(image.grid.dims[0] * image.grid.dims[1]));
}

void read_radii(const std::string& bytes) {
  const std::vector<Vec3> points{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  EXPECT_EQ(io::read_radii(memory_file().holding(bytes), points).size(), points.size());
}

template <class Header>
std::function<void(const std::string&)> read_stored(const Header& header) {
  return [header](const std::string& bytes) {
    const std::filesystem::path file = memory_file().holding(bytes);
    const Volume volume = io::read_stream(io::open_stored(file, header(file), nullptr), file, nullptr);
    const auto& dims = volume.grid.dims;
    EXPECT_EQ(view_of(volume).strides[2] * dims[2] / view_of(volume).strides[0], dims[0] * dims[1] * dims[2]);
    EXPECT_TRUE(volume.grid.spacing.allFinite() && volume.grid.spacing.minCoeff() > 0);
    EXPECT_LT((volume.grid.direction.transpose() * volume.grid.direction - Mat3::Identity()).norm(), 1e-9);
  };
}

void read_tiff(const std::string& bytes) {
  const auto& file = memory_file().holding(bytes);
  io::read_stream(io::open_tiff(file, {}, nullptr), file, nullptr);
}

/// A box of voxels far from each other is large, whatever their number.
void read_out(const std::string& bytes) {
  const auto& file = memory_file().holding(bytes);
  const SliceStream stream = io::open_out_voxels(file, nullptr);
  const auto& dims = stream.grid.dims;
  if (static_cast<double>(dims[0]) * static_cast<double>(dims[1]) * static_cast<double>(dims[2]) < 1e6)
    io::read_stream(stream, file, nullptr);
}

void read_tree(const std::string& bytes, bool swc) {
  const Tree tree = swc ? io::read_swc({"file", bytes}, nullptr) : io::read_rsml({"file", bytes}, nullptr);
  for (const Tree::Branch& branch : tree.branches)
    for (const Vec3& point : branch.points) EXPECT_TRUE(point.allFinite());
}

std::function<void(const std::string&)> reader_of(const std::string& format) {
  if (format == "ply") return read_poly<io::read_ply>;
  if (format == "obj") return read_poly<io::read_obj>;
  if (format == "off") return read_poly<io::read_off>;
  if (format == "stl") return read_poly<io::read_stl>;
  if (format == "vtp") return read_poly<io::read_vtp>;
  if (format == "ma") return read_poly<io::read_ma>;
  if (format == "radii") return read_radii;
  if (format == "npy") return read_samples<io::read_npy>;
  if (format == "vol") return read_samples<io::read_vol>;
  if (format == "sof") return read_samples<io::read_sof>;
  if (format == "png") return read_pixels<io::read_png>;
  if (format == "pnm") return read_pixels<io::read_pnm>;
  if (format == "bmp") return read_pixels<io::read_bmp>;
  if (format == "jpeg") return read_pixels<io::read_jpeg>;
  if (format == "tiff") return read_tiff;
  if (format == "out") return read_out;
  if (format == "swc") return [](const std::string& bytes) { read_tree(bytes, true); };
  if (format == "rsml") return [](const std::string& bytes) { read_tree(bytes, false); };
  if (format == "nrrd") return read_stored(io::nrrd_header);
  if (format == "mha") return read_stored([](const auto& file) { return io::meta_header(file, nullptr); });
  if (format == "nii") return read_stored([](const auto& file) { return io::nifti_header(file, nullptr); });
  return read_stored(io::mrc_header);
}

std::vector<SmallFile> files() {
  std::vector<SmallFile> list = small_files::all();
  Record data = testing_files::mixed_sample();
  data.point_data.resize(2);
  data.cell_data.resize(1);
  data.field_data.resize(2);
  for (const char* format : {"ply", "obj", "vtp", "ma"}) {
    const std::string name = std::string("written.") + format;
    io::write_record(folder() / name, data);
    list.push_back({name, format, testing_files::bytes_of(folder() / name)});
  }
#ifndef QUENCH_TESTS_HAVE_JPEG
  std::erase_if(list, [](const SmallFile& file) { return file.format == "jpeg"; });
#endif
#ifndef QUENCH_TESTS_HAVE_TIFF
  std::erase_if(list, [](const SmallFile& file) { return file.format == "tiff"; });
#endif
  return list;
}

/// Success, or one sentence as an input error; anything else, or much memory, fails the test.
bool is_handled(const SmallFile& file, const std::string& bytes, const std::string& how) {
  // A .sof file of a few bytes may be a large empty grid, zlib makes a thousand bytes of one.
  constexpr std::size_t much = std::size_t{64} << 20;
  largest_allocation = 0;
  std::string complaint;
  try {
    reader_of(file.format)(bytes);
  } catch (const Error& error) {
    const std::string sentence = error.what();
    if (error.code() != ErrorCode::input || sentence.empty() ||
        std::any_of(sentence.begin(), sentence.end(), [](unsigned char c) { return c < ' '; }))
      complaint = "not one sentence about the input: " + sentence;
  } catch (const std::exception& error) {
    complaint = error.what();
  }
  if (largest_allocation > much) complaint += " memory of " + std::to_string(largest_allocation) + " bytes";
  if (complaint.empty()) return true;
  ADD_FAILURE() << file.name << ", " << how << ": " << complaint;
  return false;
}

TEST(Hostile, ValidFilesAreRead) {
  for (const SmallFile& file : files()) EXPECT_NO_THROW(reader_of(file.format)(file.bytes)) << file.name;
}

TEST(Hostile, EveryTruncation) {
  for (const SmallFile& file : files())
    for (std::size_t size = 0; size < file.bytes.size(); ++size)
      if (!is_handled(file, file.bytes.substr(0, size), "cut to " + std::to_string(size))) break;
}

/// All values for short files that are read quickly, else those that mean something in a text or a number.
std::set<int> values_for(const SmallFile& file, char old) {
  std::vector<int> values{0,   255,      old ^ 1,  old ^ 128, old + 1,  old - 1, int{' '}, int{'\n'},
                          '0', int{'9'}, int{'-'}, int{'"'},  int{'<'}, 127,     128};
  if (file.bytes.size() < 300 && file.format != "tiff") {
    values.resize(256);
    std::iota(values.begin(), values.end(), 0);
  }
  std::set<int> different;  // several are the same byte
  for (const int value : values) different.insert(value & 255);
  return different;
}

TEST(Hostile, EveryByteChanged) {
  for (const SmallFile& file : files())
    for (std::size_t at = 0; at < file.bytes.size(); ++at)
      for (std::size_t turn = at; const int value : values_for(file, file.bytes[at])) {
        if (!full_run() && ++turn % 4 != 0) continue;  // other values at the next byte
        std::string bytes = file.bytes;
        bytes[at] = static_cast<char>(value);
        // The checksums of PNG would hide what is behind them.
        for (const bool mended : {false, true}) {
          if (mended && file.format != "png") continue;
          if (mended) small_files::mend_checksums(bytes);
          if (!is_handled(file, bytes, "byte " + std::to_string(at) + " = " + std::to_string(value))) return;
        }
      }
}

// What fuzzing found; each was once not one sentence about the input.
TEST(Hostile, FoundByFuzzing) {
  const auto refused = [](const char* format, const std::string& bytes, const std::string& word) {
    const SmallFile file{std::string("found.") + format, format, bytes};
    EXPECT_TRUE(is_handled(file, bytes, "as found"));
    try {
      reader_of(format)(bytes);
      ADD_FAILURE() << format << " was read";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  // Texts of the file were repeated in the sentence with their line ends.
  refused("npy", small_files::npy("|u1\n\nu1", false, "2, 2, 2", "12345678"), "|u1??u1");
  refused("vol", "X: 2\1\nY: 2\nZ: 2\n.\n12345678", "2?");
  refused("vtp", "<VTKFile type=\"Poly&#10;Data\"/>", "Poly?Data");
  // One less than the smallest integer.
  refused("ma", "-9223372036854775808 1 1\nv 0 0 0 1\ne 0 1\n", "negative");
}

TEST(Hostile, PiecesRemovedRepeatedAndSwapped) {
  std::mt19937 random(7);
  for (const SmallFile& file : files())
    for (int round = 0; round < 1000; ++round) {
      std::string bytes = file.bytes;
      for (int edit = 1 + static_cast<int>(random() % 3); edit > 0 && !bytes.empty(); --edit) {
        const std::size_t from = random() % bytes.size(), size = random() % 20, to = random() % bytes.size();
        const std::string part = bytes.substr(from, size);
        switch (random() % 3) {
          case 0:
            bytes.erase(from, size);
            break;
          case 1:
            bytes.insert(to, part);
            break;
          default:
            bytes.replace(to, size, part);
        }
      }
      if (!is_handled(file, bytes, "edit " + std::to_string(round))) break;
    }
}

}  // namespace
}  // namespace quench
