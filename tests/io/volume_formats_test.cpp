// SPDX-License-Identifier: Apache-2.0
// Our own readers: .npy, .vol, .sof. The writers here follow the formats' descriptions, not the readers.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <random>

#include "quench/error.h"
#include "quench/io.h"
#include "random_shapes.h"
#include "temporary_folder.h"

namespace quench {
namespace volume_formats_test {

template <class T>
std::string bytes_of(const std::vector<T>& values, bool big_endian = false) {
  std::string bytes;
  for (const T& v : values) {
    std::string one(sizeof(T), '\0');
    std::memcpy(one.data(), &v, sizeof(T));
    if (big_endian) std::reverse(one.begin(), one.end());
    bytes += one;
  }
  return bytes;
}

std::string npy(int version, const std::string& dictionary, const std::string& samples) {
  std::string bytes = "\x93NUMPY";
  bytes += {static_cast<char>(version), '\0'};
  bytes += bytes_of(std::vector<std::uint16_t>{static_cast<std::uint16_t>(dictionary.size())});
  if (version > 1) bytes += std::string(2, '\0');
  return bytes + dictionary + samples;
}

std::string npy(const std::string& descr, bool fortran, const std::string& shape, const std::string& samples) {
  return npy(
      1,
      fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': {}, }}\n", descr, fortran ? "True" : "False", shape),
      samples);
}

template <class T>
std::vector<T> samples_of(const Volume& volume) {
  return std::get<std::vector<T>>(volume.samples);
}

std::string deflated(const std::string& data) {
  std::vector<unsigned char> out(compressBound(data.size()));
  uLongf size = out.size();
  compress(out.data(), &size, reinterpret_cast<const unsigned char*>(data.data()), data.size());
  return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size)};
}

std::string vol(std::array<int, 3> dims, int bytes, int version, const std::string& samples,
                const std::string& endian = "0") {
  return fmt::format(
             "Center-X: 1\nCenter-Y: 1\nCenter-Z: 1\nX: {}\nY: {}\nZ: {}\nVoxel-Size: {}\nAlpha-Color: 0\n"
             "Voxel-Endian: {}\nInt-Endian: 0123\nVersion: {}\n.\n",
             dims[0], dims[1], dims[2], bytes, endian, version) +
         (version == 3 ? deflated(samples) : samples);
}

// Pre-order octree of the signs at the (n+1)^3 corners: a cell whose corners all agree is empty.
void append_cell(std::string& out, const VoxelShape& shape, int x, int y, int z, int size) {
  int inside = 0;
  for (int k = z; k <= z + size; ++k)
    for (int j = y; j <= y + size; ++j)
      for (int i = x; i <= x + size; ++i) inside += shape.contains(i, j, k);
  const int all = (size + 1) * (size + 1) * (size + 1);
  if (inside == 0 || inside == all) {
    out += {1, static_cast<char>(inside == 0)};
  } else if (size == 1) {
    int signs = 0;
    for (int dx = 0; dx < 2; ++dx)
      for (int dy = 0; dy < 2; ++dy)
        for (int dz = 0; dz < 2; ++dz) signs |= !shape.contains(x + dx, y + dy, z + dz) << (4 * dx + 2 * dy + dz);
    out += {2, static_cast<char>(signs)};
  } else {
    out += '\0';
    for (int dx = 0; dx < 2; ++dx)
      for (int dy = 0; dy < 2; ++dy)
        for (int dz = 0; dz < 2; ++dz)
          append_cell(out, shape, x + dx * size / 2, y + dy * size / 2, z + dz * size / 2, size / 2);
  }
}

std::string sof(const VoxelShape& shape) {
  const auto n = static_cast<std::int32_t>(shape.grid().dims[0] - 1);
  std::string out = bytes_of(std::vector<std::int32_t>{n});
  append_cell(out, shape, 0, 0, 0, n);
  return out;
}

void expect_error(const std::filesystem::path& file, ErrorCode code, const std::string& part) {
  try {
    io::read_volume(file);
    ADD_FAILURE() << file << " was read";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), code) << e.what();
    EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find(file.filename().string()), std::string::npos) << e.what();
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
  }
}

// Any file must be read or refused by one sentence, and nothing else.
void read_or_refuse(const std::filesystem::path& file) {
  try {
    const Volume volume = io::read_volume(file);
    const auto& d = volume.grid.dims;
    std::visit([&](const auto& s) { EXPECT_EQ(s.size(), static_cast<std::size_t>(d[0] * d[1] * d[2])); },
               volume.samples);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::input) << e.what();
  }
}

void every_truncation_and_mutation(const std::string& name, const std::string& bytes, bool prefix_is_error) {
  const TemporaryFolder folder;
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const auto file = folder.write(name, bytes.substr(0, length));
    if (prefix_is_error)
      EXPECT_THROW(io::read_volume(file), Error) << length;
    else
      read_or_refuse(file);
  }
  std::mt19937 random(1);
  for (std::size_t at = 0; at < bytes.size(); ++at)
    for (const int change : {1, 0x80, 0xff, static_cast<int>(1 + random() % 254)}) {
      std::string mutated = bytes;
      mutated[at] = static_cast<char>(mutated[at] ^ change);
      read_or_refuse(folder.write(name, mutated));
    }
}

TEST(Npy, MemoryOrderDecidesTheAxes) {
  const TemporaryFolder folder;
  const std::vector<std::uint8_t> values{0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11,
                                         12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23};
  const Volume c = io::read_volume(folder.write("c.npy", npy("|u1", false, "(2, 3, 4)", bytes_of(values))));
  EXPECT_EQ(c.grid.dims, (std::array<std::int64_t, 3>{4, 3, 2}));
  EXPECT_EQ(samples_of<std::uint8_t>(c), values);
  const Volume f = io::read_volume(folder.write("f.npy", npy("|u1", true, "(2, 3, 4)", bytes_of(values))));
  EXPECT_EQ(f.grid.dims, (std::array<std::int64_t, 3>{2, 3, 4}));
  EXPECT_EQ(samples_of<std::uint8_t>(f), values);
  const Volume flat = io::read_volume(folder.write("2.npy", npy("|u1", false, "(4, 6)", bytes_of(values))));
  EXPECT_EQ(flat.grid.dims, (std::array<std::int64_t, 3>{6, 4, 1}));
  EXPECT_TRUE(flat.grid.is_plane());
  const Volume four = io::read_volume(folder.write("4.npy", npy("|u1", false, "(1, 2, 3, 4)", bytes_of(values))));
  EXPECT_EQ(four.grid.dims, (std::array<std::int64_t, 3>{4, 3, 2}));
}

template <class T>
void expect_type(const TemporaryFolder& folder, const std::string& type) {
  std::vector<T> values(6);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<T>(i * 37 - 50);
  values[5] = std::numeric_limits<T>::max();
  for (const bool big : {false, true}) {
    const auto file = folder.write("t.npy", npy((big ? ">" : "<") + type, false, "(2,1,3)", bytes_of(values, big)));
    EXPECT_EQ(samples_of<T>(io::read_volume(file)), values) << type << big;
  }
}

TEST(Npy, EveryTypeAndByteOrder) {
  const TemporaryFolder folder;
  expect_type<std::uint8_t>(folder, "u1");
  expect_type<std::int8_t>(folder, "i1");
  expect_type<std::uint16_t>(folder, "u2");
  expect_type<std::int16_t>(folder, "i2");
  expect_type<std::uint32_t>(folder, "u4");
  expect_type<std::int32_t>(folder, "i4");
  expect_type<std::uint64_t>(folder, "u8");
  expect_type<std::int64_t>(folder, "i8");
  expect_type<float>(folder, "f4");
  expect_type<double>(folder, "f8");
  const std::vector<std::uint16_t> halves{0x3c00, 0xc000, 0x7bff, 0x0001, 0x0000, 0x7c00};
  const Volume half = io::read_volume(folder.write("h.npy", npy(">f2", false, "(2,1,3)", bytes_of(halves, true))));
  EXPECT_EQ(samples_of<float>(half),
            (std::vector<float>{1, -2, 65504, std::ldexp(1.0f, -24), 0, std::numeric_limits<float>::infinity()}));
  const std::string booleans("\1\0\1\0", 4);
  for (const int version : {1, 2, 3}) {
    const auto file = folder.write(
        "b.npy", npy(version, "{'descr': '|b1', 'fortran_order': False, 'shape': (2L, 1L, 2L)}", booleans));
    EXPECT_EQ(samples_of<std::uint8_t>(io::read_volume(file)), (std::vector<std::uint8_t>{1, 0, 1, 0}));
  }
}

TEST(Npy, RefusesWhatIsNoVolume) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& bytes, const std::string& part) {
    expect_error(folder.write("bad.npy", bytes), ErrorCode::input, part);
  };
  refused("", "is empty");
  refused("PK\3\4 something else", "NUMPY");
  refused(npy("<c8", false, "(1,1,1)", std::string(8, 'x')), "<c8");
  refused(npy("|O", false, "(1,1,1)", "x"), "plain numbers");
  refused(npy("|u1", false, "(8,)", std::string(8, 'x')), "axes");
  refused(npy("|u1", false, "(2,2,2,2)", std::string(16, 'x')), "axes");
  refused(npy("|u1", false, "(0,2,2)", ""), "every side");
  refused(npy("|u1", false, "(-1,2,2)", ""), "every side");
  refused(npy("|u1", false, "(1000,1000,100000)", "xx"), "too short");
  refused(npy("<f8", false, "(2000000000,2000000000,2000000000)", "xx"), "more than any memory");
  refused(npy("|u1", false, "(99999999999999999999,1,1)", "xx"), "tuple of numbers");
  refused(npy(1, "{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (1,1,1)}", "xxxx"), "records");
  refused(npy(9, "{}", ""), "version");
  expect_error(folder / "missing.npy", ErrorCode::failed, "cannot be opened");
}

TEST(Npy, IsReadAsNumpyWritesIt) {
  if (std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3-numpy is not installed";
  const TemporaryFolder folder;
  const auto script = folder.write(
      "write.py",
      "import sys, numpy as np\n"
      "a = np.arange(2*3*5).reshape(2, 3, 5)\n"
      "for t in ['b1', 'u1', 'u2', 'u4', 'u8', 'i1', 'i2', 'i4', 'i8', 'f2', 'f4', 'f8', '>u2', '>i8', '>f4', '>f8']:\n"
      "    v = a.astype(t)\n"
      "    name = sys.argv[1] + '/' + t.replace('>', 'big')\n"
      "    np.save(name + '_c.npy', v)\n"
      "    np.save(name + '_f.npy', np.asfortranarray(v))\n");
  ASSERT_EQ(std::system(fmt::format("/usr/bin/python3 '{}' '{}'", script.string(), folder.path().string()).c_str()), 0);
  for (const std::string type :
       {"b1", "u1", "u2", "u4", "u8", "i1", "i2", "i4", "i8", "f2", "f4", "f8", "bigu2", "bigi8", "bigf4", "bigf8"}) {
    // a[i][j][k] = 15 i + 5 j + k; C order: (z, y, x) = (i, j, k); Fortran order: (x, y, z) = (i, j, k).
    for (const bool fortran : {false, true}) {
      const Volume volume = io::read_volume(folder / (type + (fortran ? "_f.npy" : "_c.npy")));
      const auto& d = volume.grid.dims;
      EXPECT_EQ(d, (fortran ? std::array<std::int64_t, 3>{2, 3, 5} : std::array<std::int64_t, 3>{5, 3, 2})) << type;
      std::visit(
          [&](const auto& samples) {
            std::size_t at = 0;
            for (int z = 0; z < d[2]; ++z)
              for (int y = 0; y < d[1]; ++y)
                for (int x = 0; x < d[0]; ++x) {
                  const int value = fortran ? 15 * x + 5 * y + z : 15 * z + 5 * y + x;
                  EXPECT_EQ(static_cast<double>(samples[at++]), type == "b1" ? value != 0 : value) << type << fortran;
                }
          },
          volume.samples);
    }
  }
}

TEST(Npy, EveryTruncationAndMutation) {
  const std::vector<std::uint16_t> values{1, 2, 3, 4, 5, 6, 7, 8};
  every_truncation_and_mutation("m.npy", npy("<u2", false, "(2, 2, 2)", bytes_of(values)), true);
}

TEST(Vol, EveryVersionAndSize) {
  const TemporaryFolder folder;
  const std::vector<std::uint8_t> small{1, 2, 3, 4, 5, 6};
  const std::vector<std::uint16_t> middle{1, 2, 300, 4, 5, 65535};
  const std::vector<std::uint32_t> large{1, 2, 300, 4, 5, 4000000000u};
  for (const int version : {2, 3}) {
    const Volume v = io::read_volume(folder.write("a.vol", vol({3, 1, 2}, 1, version, bytes_of(small))));
    EXPECT_EQ(v.grid.dims, (std::array<std::int64_t, 3>{3, 1, 2}));
    EXPECT_EQ(samples_of<std::uint8_t>(v), small);
    EXPECT_EQ(
        samples_of<std::uint16_t>(io::read_volume(folder.write("b.vol", vol({3, 1, 2}, 2, version, bytes_of(middle))))),
        middle);
    EXPECT_EQ(samples_of<std::uint16_t>(
                  io::read_volume(folder.write("b.vol", vol({3, 1, 2}, 2, version, bytes_of(middle, true), "10")))),
              middle);
    EXPECT_EQ(
        samples_of<std::uint32_t>(io::read_volume(folder.write("c.vol", vol({3, 1, 2}, 4, version, bytes_of(large))))),
        large);
  }
}

TEST(Vol, RefusesWhatItCannotHold) {
  const TemporaryFolder folder;
  for (const int version : {2, 3})
    expect_error(folder.write("a.vol", vol({2000, 2000, 2000}, 1, version, "abc")), ErrorCode::input, "too short");
  expect_error(folder.write("b.vol", vol({3, 3, 3}, 1, 3, "abc")), ErrorCode::input, "end after 3 of 27");
  expect_error(folder.write("c.vol", vol({1, 1, 1}, 3, 2, "abc")), ErrorCode::input, "Voxel-Size 3");
  expect_error(folder.write("d.vol", vol({1, 1, 1}, 1, 7, "abc")), ErrorCode::input, "version 7");
  expect_error(folder.write("e.vol", "X: 1\nY: 1\n.\nabc"), ErrorCode::input, "lacks Z");
  expect_error(folder.write("f.vol", "X: 1\nY: 1\n"), ErrorCode::input, "one dot");
  expect_error(folder.write("g.vol", "X: many\nY: 1\nZ: 1\n.\na"), ErrorCode::input, "whole number");
}

TEST(Vol, EveryTruncationAndMutation) {
  const std::string samples = bytes_of(std::vector<std::uint16_t>{1, 2, 3, 4, 5, 6, 7, 8});
  every_truncation_and_mutation("m.vol", vol({2, 2, 2}, 2, 2, samples), true);
  every_truncation_and_mutation("m.vol", vol({2, 2, 2}, 2, 3, samples), false);
}

TEST(Sof, RoundTripOfRandomShapes) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const VoxelShape random = testing_shapes::random_shape(seed, 12);
    const int n = 1 << (seed % 5);
    Grid grid;
    grid.dims.fill(n + 1);
    const VoxelShape shape =
        testing_shapes::from_predicate(grid, [&](int x, int y, int z) { return random.contains(x, y, z); });
    if (shape.empty() || shape.voxel_count() == grid.dims[0] * grid.dims[1] * grid.dims[2]) continue;
    const Volume volume = io::read_volume(folder.write("s.sof", sof(shape)));
    const VoxelShape back = foreground(volume, {});
    ASSERT_EQ(back.grid().dims, grid.dims);
    for (std::int64_t z = 0; z <= n; ++z)
      for (std::int64_t y = 0; y <= n; ++y)
        ASSERT_TRUE(std::ranges::equal(back.row(y, z), shape.row(y, z))) << "seed " << seed;
  }
}

// One corner of one leaf outside: corner (1,0,1) is bit 4 + 1.
TEST(Sof, TakesTheBitsAsWritten) {
  const TemporaryFolder folder;
  const auto file = folder.write("one.sof", bytes_of(std::vector<std::int32_t>{1}) + std::string("\x02\x20", 2));
  EXPECT_EQ(samples_of<std::uint8_t>(io::read_volume(file)), (std::vector<std::uint8_t>{1, 1, 1, 1, 1, 0, 1, 1}));
}

TEST(Sof, RefusesHostileFiles) {
  const TemporaryFolder folder;
  const auto refused = [&](std::int32_t n, const std::string& nodes, const std::string& part) {
    expect_error(folder.write("bad.sof", bytes_of(std::vector<std::int32_t>{n}) + nodes), ErrorCode::input, part);
  };
  refused(3, "\1\1", "power of 2");
  refused(-8, "\1\1", "power of 2");
  refused(1 << 30, "\1\1", "power of 2");
  refused(1024, std::string("\1\0", 2), "too few");
  refused(2, "\2\7", "size 1");
  refused(1, std::string("\0\1", 2), "below size 1");
  refused(1, "\2\7\7", "ends at byte");
  refused(1, "\3\7", "not a node type");
  // One leaf in the corner of 2048^3 corners, everything else "inside".
  std::string deep;
  for (int level = 0; level < 11; ++level) deep += '\0';
  deep += "\2\7";
  for (int i = 0; i < 77; ++i) deep += std::string("\1\0", 2);
  refused(2048, deep, "too few");
}

TEST(Sof, EveryTruncationAndMutation) {
  Grid grid;
  grid.dims.fill(5);
  const VoxelShape shape = testing_shapes::from_predicate(grid, [](int x, int y, int z) { return x + y + z < 4; });
  every_truncation_and_mutation("m.sof", sof(shape), true);
}

}  // namespace volume_formats_test
}  // namespace quench
