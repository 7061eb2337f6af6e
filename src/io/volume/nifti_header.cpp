// SPDX-License-Identifier: Apache-2.0
// NIfTI-1 and NIfTI-2 headers in one file with the samples (nifti.nimh.nih.gov/nifti-1, nifti-2). World coordinates of
// the format are right-anterior-superior; those given back are left-posterior-superior, in millimetres.
#include <fmt/format.h>
#include <zlib.h>

#include <Eigen/Geometry>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>

#include "io/volume/header_bytes.h"
#include "io/volume/stored_volume.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

/// What the headers of both versions hold.
struct Nifti {
  std::array<std::int64_t, 8> dim{};
  std::array<double, 8> pixdim{};
  int datatype = 0, qform_code = 0, sform_code = 0, units = 0;
  bool swapped = false, packed = false;
  std::size_t size = 0;  ///< of the header
  double vox_offset = 0, slope = 0, intercept = 0;
  std::array<double, 3> quatern{}, offset{};
  std::array<std::array<double, 4>, 3> srow{};
};

Nifti version_1(const HeaderBytes& h) {
  Nifti n;
  for (std::size_t i = 0; i < 8; ++i) {
    n.dim[i] = h.at<std::int16_t>(40 + 2 * i);
    n.pixdim[i] = decimal(h.at<float>(76 + 4 * i));
  }
  n.datatype = h.at<std::int16_t>(70);
  n.vox_offset = static_cast<double>(h.at<float>(108));
  n.slope = decimal(h.at<float>(112));
  n.intercept = decimal(h.at<float>(116));
  n.units = h.at<std::uint8_t>(123);
  n.qform_code = h.at<std::int16_t>(252);
  n.sform_code = h.at<std::int16_t>(254);
  for (std::size_t i = 0; i < 3; ++i) {
    n.quatern[i] = static_cast<double>(h.at<float>(256 + 4 * i));
    n.offset[i] = decimal(h.at<float>(268 + 4 * i));
    for (std::size_t j = 0; j < 4; ++j) n.srow[i][j] = decimal(h.at<float>(280 + 16 * i + 4 * j));
  }
  return n;
}

Nifti version_2(const HeaderBytes& h) {
  Nifti n;
  for (std::size_t i = 0; i < 8; ++i) {
    n.dim[i] = h.at<std::int64_t>(16 + 8 * i);
    n.pixdim[i] = h.at<double>(104 + 8 * i);
  }
  n.datatype = h.at<std::int16_t>(12);
  n.vox_offset = static_cast<double>(h.at<std::int64_t>(168));
  n.slope = h.at<double>(176);
  n.intercept = h.at<double>(184);
  n.qform_code = h.at<std::int32_t>(344);
  n.sform_code = h.at<std::int32_t>(348);
  n.units = h.at<std::int32_t>(500);
  for (std::size_t i = 0; i < 3; ++i) {
    n.quatern[i] = h.at<double>(352 + 8 * i);
    n.offset[i] = h.at<double>(376 + 8 * i);
    for (std::size_t j = 0; j < 4; ++j) n.srow[i][j] = h.at<double>(400 + 32 * i + 8 * j);
  }
  return n;
}

constexpr std::size_t kSize1 = 348, kSize2 = 540;

Nifti read_header(const std::filesystem::path& file) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> gz(gzopen(file.c_str(), "rb"), gzclose);
  if (!gz) throw Error(ErrorCode::failed, fmt::format("'{}' cannot be opened", file.string()));
  std::vector<unsigned char> bytes(kSize2);
  const int got = gzread(gz.get(), bytes.data(), kSize2);
  int state = Z_OK;
  gzerror(gz.get(), &state);
  if (got < 0 || state == Z_DATA_ERROR)
    refuse_volume(file, "its compressed data are damaged; copy or download it again");
  if (got < static_cast<int>(kSize1)) refuse_volume(file, "it is shorter than a header; it is damaged or incomplete");
  std::int32_t size = 0;
  std::memcpy(&size, bytes.data(), sizeof size);
  const auto swapped_size = static_cast<std::int32_t>(__builtin_bswap32(static_cast<std::uint32_t>(size)));
  const bool one = size == kSize1 || swapped_size == kSize1, two = size == kSize2 || swapped_size == kSize2;
  if (!one && !two) refuse_volume(file, "it does not begin as a NIfTI file");
  const bool swapped = swapped_size == kSize1 || swapped_size == kSize2;
  const auto* magic = reinterpret_cast<const char*>(bytes.data()) + (one ? 344 : 4);
  if (std::string_view(magic, 3) == (one ? "ni1" : "ni2"))
    refuse_volume(file, "it is the header of a pair of files (.hdr, .img); save both as one file");
  if (std::string_view(magic, 3) != (one ? "n+1" : "n+2"))
    refuse_volume(
        file, "its header does not have the mark of a NIfTI file (an older ANALYZE file has none); save it as NIfTI");
  if (two && got < static_cast<int>(kSize2))
    refuse_volume(file, "it is shorter than a header; it is damaged or incomplete");
  const HeaderBytes header(std::move(bytes), swapped);
  Nifti n = one ? version_1(header) : version_2(header);
  n.size = one ? kSize1 : kSize2;
  n.swapped = swapped;
  n.packed = gzdirect(gz.get()) == 0;
  return n;
}

void set_type(const std::filesystem::path& file, const Nifti& n, StoredVolume& volume) {
  constexpr std::pair<int, SampleType> kTypes[] = {
      {2, SampleType::uint8},    {4, SampleType::int16},    {8, SampleType::int32},    {16, SampleType::float32},
      {64, SampleType::float64}, {256, SampleType::int8},   {512, SampleType::uint16}, {768, SampleType::uint32},
      {1024, SampleType::int64}, {1280, SampleType::uint64}};
  for (const auto& [code, type] : kTypes)
    if (code == n.datatype) {
      volume.type.type = type;
      return;
    }
  const char* name = n.datatype == 128                                              ? "colours (RGB)"
                     : n.datatype == 2304                                           ? "colours (RGBA)"
                     : n.datatype == 32 || n.datatype == 1792 || n.datatype == 2048 ? "complex numbers"
                     : n.datatype == 1                                              ? "single bits"
                     : n.datatype == 1536                                           ? "long doubles"
                                                                                    : "unknown";
  refuse_volume(file, fmt::format("its samples are {} (data type {}); convert them to integers, float or double", name,
                                  n.datatype));
}

/// Steps between voxels and the position of voxel 0, right-anterior-superior.
struct Placement {
  Mat3 steps = Mat3::Identity();
  Vec3 origin = Vec3::Zero();
  const char* source = "";
};

Placement by_sform(const Nifti& n) {
  Placement p;
  p.source = "the sform of the header";
  for (int row = 0; row < 3; ++row) {
    const auto& from = n.srow[static_cast<std::size_t>(row)];
    p.steps.row(row) << from[0], from[1], from[2];
    p.origin[row] = from[3];
  }
  return p;
}

/// Method 2 of the standard.
Placement by_qform(const Nifti& n, const Vec3& spacing) {
  Placement p;
  p.source = "the qform of the header";
  double b = n.quatern[0], c = n.quatern[1], d = n.quatern[2];
  double a = 1 - (b * b + c * c + d * d);
  if (a < 1e-7) {  // a half turn, rounded
    const double length = std::sqrt(b * b + c * c + d * d);
    b /= length;
    c /= length;
    d /= length;
    a = 0;
  }
  const Mat3 rotation = Eigen::Quaterniond(std::sqrt(a), b, c, d).toRotationMatrix();
  p.steps = rotation * spacing.asDiagonal();
  if (n.pixdim[0] < 0) p.steps.col(2) *= -1;
  p.origin = Vec3(n.offset[0], n.offset[1], n.offset[2]);
  return p;
}

bool perpendicular(const Mat3& steps) {
  for (int a = 0; a < 3; ++a) {
    const double length = steps.col(a).stableNorm();
    if (!(length > 0) || !std::isfinite(length)) return false;
    if (!(std::abs(steps.col(a).stableNormalized().dot(steps.col((a + 1) % 3).stableNormalized())) <= 1e-4))
      return false;
  }
  return true;
}

void set_grid(const std::filesystem::path& file, const Nifti& n, StoredVolume& volume, Context* context) {
  Grid& grid = volume.grid;
  if (n.dim[0] < 1 || n.dim[0] > 7) refuse_volume(file, fmt::format("it claims {} axes; a volume has three", n.dim[0]));
  grid.dims.fill(1);
  if (n.dim[0] == 2) grid.dimension = 2;
  Vec3 spacing = Vec3::Ones();
  for (std::size_t a = 0; a < static_cast<std::size_t>(n.dim[0]); ++a) {
    if (a < 3) {
      grid.dims[a] = n.dim[a + 1];
      const double size = std::abs(n.pixdim[a + 1]);
      if (!std::isfinite(size))
        refuse_volume(file,
                      fmt::format("the size of its voxels along axis {} is {} (pixdim); correct its header", a, size));
      spacing[static_cast<int>(a)] = size > 0 ? size : 1;  // 0: not known
    } else if (n.dim[a + 1] != 1) {
      refuse_volume(file,
                    fmt::format("it is an image of {} dimensions with {} volumes; save the one you mean on its own",
                                n.dim[0], n.dim[a + 1]));
    }
  }
  Placement placement;
  placement.steps = spacing.asDiagonal();
  placement.source = "the pixdim of the header";
  bool oriented = true;
  const Placement sform = by_sform(n);
  if (n.sform_code > 0 && (perpendicular(sform.steps) || n.qform_code <= 0)) {
    placement = sform;
  } else if (n.qform_code > 0) {
    placement = by_qform(n, spacing);
    if (n.sform_code > 0)
      note(context, fmt::format("the sform of '{}' is {}; its qform is taken", file.string(),
                                sform.steps.isZero() ? "zero" : "sheared or without a direction"));
  } else {
    oriented = false;
  }
  if (oriented) {
    placement.steps.topRows<2>() *= -1;  // right-anterior to left-posterior
    placement.origin.head<2>() *= -1;
    volume.coordinates.space = "LPS";
  }
  set_steps(file, placement.steps, n.sform_code > 0 ? "sform" : n.qform_code > 0 ? "qform" : "pixdim", grid);
  grid.origin = placement.origin + Vec3::Zero();  // 0 for -0
  // Single precision and the product of a matrix leave noise in the lengths of steps; pixdim has the same without.
  for (int a = 0; a < 3; ++a)
    if (std::abs(grid.spacing[a] - spacing[a]) <= 1e-5 * spacing[a]) grid.spacing[a] = spacing[a];
  const int unit = n.units & 7;
  const double millimetres = unit == 1 ? 1000 : unit == 3 ? 0.001 : 1;
  grid.spacing *= millimetres;
  grid.origin *= millimetres;
  if (unit >= 1 && unit <= 3) volume.coordinates.units = "mm";
  volume.spacing_source = placement.source;
}

}  // namespace

StoredVolume nifti_header(const std::filesystem::path& file, Context* context) {
  const InputFile probe(file);  // throws for a file that cannot be opened or is empty
  const Nifti n = read_header(file);
  StoredVolume volume;
  set_type(file, n, volume);
  set_grid(file, n, volume, context);
  volume.swapped = n.swapped;
  if (n.slope != 0 && std::isfinite(n.slope) && std::isfinite(n.intercept)) {  // 0: not scaled
    volume.slope = n.slope;
    volume.intercept = n.intercept;
  }
  constexpr double kFarthest = 0x1p53;
  if (!(n.vox_offset >= static_cast<double>(n.size) && n.vox_offset <= kFarthest) ||
      n.vox_offset != std::floor(n.vox_offset))
    refuse_volume(file, fmt::format("its samples begin at byte {} (vox_offset), where its header has {} bytes",
                                    n.vox_offset, n.size));
  const auto begin = static_cast<std::uint64_t>(n.vox_offset);
  volume.encoding = n.packed ? Encoding::deflate : Encoding::raw;
  volume.blocks.push_back({file, n.packed ? 0 : begin, n.packed ? begin : 0, {}});
  return volume;
}

}  // namespace quench::io
