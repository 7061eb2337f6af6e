// SPDX-License-Identifier: Apache-2.0
// The only file that knows ITK. World coordinates are ITK's: left-posterior-superior for NIfTI and for NRRD files that
// name an anatomical space.
#include <dlfcn.h>
#include <fmt/format.h>
#include <itkImageIORegion.h>
#include <itkMRCImageIO.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkTIFFImageIO.h>
#include <zlib.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdarg>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>

#include "io/apart.h"
#include "io/itk_header.h"
#include "io/volume_formats.h"
#include "quench/error.h"
#include "quench/memory.h"

namespace quench::io {
namespace {

using ImageIO = itk::ImageIOBase;

// Largest deviation of D^T D from the identity that is taken for rounding: 1/20 voxel at the end of 500.
constexpr double shear_tolerance = 1e-4;

itk::SmartPointer<ImageIO> image_io(const std::string& extension) {
  const auto as_base = [](auto io) { return itk::SmartPointer<ImageIO>(io.GetPointer()); };
  if (extension == ".nrrd" || extension == ".nhdr") return as_base(itk::NrrdImageIO::New());
  if (extension == ".mha" || extension == ".mhd") return as_base(itk::MetaImageIO::New());
  if (extension == ".nii" || extension == ".nii.gz") return as_base(itk::NiftiImageIO::New());
  if (extension == ".mrc" || extension == ".map") return as_base(itk::MRCImageIO::New());
  return as_base(itk::TIFFImageIO::New());
}

bool is_nrrd(const std::string& extension) { return extension == ".nrrd" || extension == ".nhdr"; }

bool is_tiff(const std::string& extension) { return extension == ".tif" || extension == ".tiff"; }

// "ITK ERROR: NrrdImageIO(0x55...): Could not read ...\n  more" as one line without the noise.
std::string one_line(std::string text) {
  if (const auto error = text.find("ERROR: "); error != std::string::npos) {
    const auto address = text.find("): ", error);
    text.erase(0, address != std::string::npos ? address + 3 : error + 7);
  }
  std::string line;
  for (const char c : text) {
    const bool space = std::isspace(static_cast<unsigned char>(c)) != 0;
    if (space && (line.empty() || line.back() == ' ')) continue;
    line.push_back(space ? ' ' : c);
  }
  while (!line.empty() && (line.back() == ' ' || line.back() == '.')) line.pop_back();
  constexpr std::size_t longest = 240;
  if (line.size() > longest) line = line.substr(0, longest) + " ...";
  return line;
}

// Size of what a gzip file holds; refuses a damaged one, which the NIfTI library reads without complaint.
std::uint64_t checked_gzip_size(const std::filesystem::path& file) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> gz(gzopen(file.c_str(), "rb"), gzclose);
  if (!gz) throw Error(ErrorCode::failed, fmt::format("'{}' cannot be opened", file.string()));
  std::vector<char> block(1 << 18);
  std::uint64_t size = 0;
  int got = 0;
  while ((got = gzread(gz.get(), block.data(), static_cast<unsigned>(block.size()))) > 0)
    size += static_cast<std::uint64_t>(got);
  int error = Z_OK;
  gzerror(gz.get(), &error);
  if (got < 0 || (error != Z_OK && error != Z_STREAM_END))
    throw Error(ErrorCode::input, fmt::format("'{}' is damaged or incomplete: its compressed data end after {} bytes",
                                              file.string(), size));
  return size;
}

// libtiff prints warnings. ITK may carry one of its own, under a prefix and without headers, so the function is looked
// up by name; where it is not found, libtiff goes on printing.
void silence_libtiff() {
  using Handler = void (*)(const char*, const char*, std::va_list);
  for (const char* name : {"TIFFSetWarningHandler", "TIFFSetErrorHandler"})
    for (const char* prefix : {"", "itk_"})
      if (void* symbol = dlsym(RTLD_DEFAULT, (std::string(prefix) + name).c_str()))
        reinterpret_cast<Handler (*)(Handler)>(symbol)(nullptr);
}

// The NIfTI library prints about such headers whatever one asks of it, so it does not get to see them.
void check_nifti_header(const std::filesystem::path& file) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> gz(gzopen(file.c_str(), "rb"), gzclose);
  std::array<unsigned char, 348> header{};
  const bool complete = gz && gzread(gz.get(), header.data(), header.size()) == static_cast<int>(header.size());
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorCode::input, fmt::format("'{}' cannot be read as NIfTI: {}", file.string(), why));
  };
  if (!complete) refuse("it is shorter than a header");
  const bool little = header[0] == 0x5c && header[1] == 1, big = header[3] == 0x5c && header[2] == 1;
  if ((header[0] == 0x1c && header[1] == 2) || (header[3] == 0x1c && header[2] == 2))
    refuse("version 2 is not supported; convert it to version 1 or to NRRD");
  if (!little && !big) refuse("it does not begin as one");
  const int axes = little ? header[40] | header[41] << 8 : header[41] | header[40] << 8;
  if (axes < 1 || axes > 7) refuse(fmt::format("it claims {} axes", axes));
}

// Where the squares of a step overflow, the NRRD library silently takes 1 for its length. The header has been parsed
// before, so it ends.
void check_nrrd_header(const std::filesystem::path& file) {
  constexpr double largest = 1e150;
  std::ifstream in(file, std::ios::binary);
  for (std::string line; std::getline(in, line) && !line.empty() && line != "\r";) {
    std::transform(line.begin(), line.end(), line.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c; });
    if (!line.starts_with("space directions:")) continue;
    for (const char* at = line.c_str() + line.find(':') + 1; *at != 0;) {
      char* end = nullptr;
      const double step = std::strtod(at, &end);
      if (end != at && !(std::abs(step) <= largest) && !std::isnan(step))  // nan may stand for an unknown step
        throw Error(ErrorCode::input,
                    fmt::format("'{}' has steps between voxels that are too large for double precision; correct the "
                                "space directions in its header",
                                file.string()));
      at = end != at ? end : at + 1;
    }
  }
}

// MetaIO and VNL report to std::cerr what they also return, and doubts about matrices. Text of other threads is lost
// for this time.
class QuietCerr {
 public:
  QuietCerr() : lock_(mutex()), before_(std::cerr.rdbuf(nullptr)) {}
  QuietCerr(const QuietCerr&) = delete;
  QuietCerr& operator=(const QuietCerr&) = delete;
  ~QuietCerr() { std::cerr.rdbuf(before_); }

 private:
  static std::mutex& mutex() {
    static std::mutex m;
    return m;
  }
  std::lock_guard<std::mutex> lock_;
  std::streambuf* before_;
};

// Upper bound of the bytes of samples that the file can hold, so that a damaged header cannot ask for more.
std::uint64_t bytes_available(const std::filesystem::path& file, const std::string& extension) {
  std::error_code error;
  const std::uint64_t own = std::filesystem::file_size(file, error);
  if (extension == ".nii" || extension == ".mrc" || extension == ".map") return own;
  if (extension == ".nhdr" || extension == ".mhd") {
    // The samples are in other files beside the header.
    std::uint64_t all = 0;
    const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
    for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
      std::error_code ignored;
      if (it->is_regular_file(ignored)) all += it->file_size(ignored);
    }
    return all * deflate_limit;
  }
  if (extension == ".nii.gz") return checked_gzip_size(file);
  if (is_tiff(extension)) return own << 20;  // a blank line of a fax page takes one bit
  return own * deflate_limit;
}

[[noreturn]] void refuse_as_itk(const std::filesystem::path& file, const itk::ExceptionObject& error) {
  const std::string reason = one_line(error.GetDescription());
  throw Error(ErrorCode::input, fmt::format("'{}' cannot be read: {}; it is damaged or of another format",
                                            file.string(), reason.empty() ? "no reason given" : reason));
}

Grid grid_of(const ImageIO& io, const std::filesystem::path& file) {
  const auto refuse = [&](const std::string& why) -> void {
    throw Error(ErrorCode::input, fmt::format("'{}' {}", file.string(), why));
  };
  const unsigned axes = io.GetNumberOfDimensions();
  for (unsigned a = 3; a < axes; ++a)
    if (io.GetDimensions(a) != 1)
      refuse(fmt::format("is an image of {} dimensions with {} volumes; save the one you mean on its own", axes,
                         io.GetDimensions(a)));
  if (io.GetPixelType() != itk::IOPixelEnum::SCALAR || io.GetNumberOfComponents() != 1)
    refuse(fmt::format("has {} values ({}) per voxel where one is needed; convert it to grey values or labels",
                       io.GetNumberOfComponents(), ImageIO::GetPixelTypeAsString(io.GetPixelType())));
  Grid grid;
  grid.dims.fill(1);
  const unsigned used = std::min(axes, 3u);
  for (unsigned a = 0; a < used; ++a) {
    grid.dims[a] = static_cast<std::int64_t>(std::min<std::uint64_t>(io.GetDimensions(a), std::uint64_t{1} << 40));
    grid.spacing[a] = io.GetSpacing(a);
    grid.origin[a] = io.GetOrigin(a);
    const std::vector<double> column = io.GetDirection(a);
    for (unsigned row = 0; row < 3; ++row)
      grid.direction(row, a) = row < used && row < column.size() ? column[row] : row == a;
    // The libraries make the direction from the vector of a step, dividing by its length.
    if (!(grid.direction.col(a).norm() > 0.5))
      refuse(
          fmt::format("has no direction of axis {}: the step between its voxels is 0 or too small for double "
                      "precision; correct the header",
                      a));
    if (grid.spacing[a] < 0) {  // some writers put a reflection there
      grid.spacing[a] = -grid.spacing[a];
      grid.direction.col(a) *= -1;
    }
  }
  const double shear = (grid.direction.transpose() * grid.direction - Mat3::Identity()).cwiseAbs().maxCoeff();
  if (!(shear <= shear_tolerance))
    refuse("has axes that are not perpendicular (a sheared direction matrix); resample it to a rectangular grid");
  if (shear > 1e-15) {  // rounded by the format: take the nearest orthonormal matrix
    const Eigen::JacobiSVD<Mat3> svd(grid.direction, Eigen::ComputeFullU | Eigen::ComputeFullV);
    grid.direction = svd.matrixU() * svd.matrixV().transpose();
  }
  return grid;
}

/// Where the samples of a MetaImage are.
struct MetaSamples {
  bool own = false;                   ///< in the file itself, as one block
  std::filesystem::path block;        ///< the file that has them as one block; empty: in several
  std::streamoff begin = 0;           ///< in `block`
  bool packed = false;                ///< by zlib
  std::optional<double> packed_size;  ///< as the header says
};

MetaSamples meta_samples(const std::filesystem::path& file) {
  MetaSamples result;
  std::ifstream in(file, std::ios::binary);
  std::string line;
  for (int lines = 0; lines < 1000 && std::getline(in, line); ++lines) {
    const auto separator = line.find_first_of("=:");
    if (separator == std::string::npos) continue;
    const auto name_end = line.find_last_not_of(" \t", separator - 1);
    const std::string name = separator == 0 || name_end == std::string::npos ? "" : line.substr(0, name_end + 1);
    const auto begin = line.find_first_not_of(" \t", separator + 1);
    const std::string value =
        begin == std::string::npos ? "" : line.substr(begin, line.find_last_not_of(" \t\r") + 1 - begin);
    if (name == "CompressedData")
      result.packed = !value.empty() && (value[0] == 'T' || value[0] == 't' || value[0] == '1');
    if (name == "CompressedDataSize") result.packed_size = std::strtod(value.c_str(), nullptr);
    if (name != "ElementDataFile") continue;
    const std::string where = value.substr(0, 5);
    result.own = where == "LOCAL" || where == "Local" || where == "local";
    if (result.own) {
      result.block = file;
      result.begin = in.tellg();
    } else if (where.substr(0, 4) != "LIST" && value.find('%') == std::string::npos) {
      result.block = file.parent_path() / value;
    }
    break;
  }
  return result;
}

/// The library takes what it can get of damaged compressed samples for all of them, and any size for that of a buffer.
void check_packed_meta(const std::filesystem::path& file, std::uint64_t bytes) {
  const MetaSamples samples = meta_samples(file);
  std::error_code unknown;
  const std::uint64_t size = std::filesystem::file_size(samples.block, unknown);
  if (!samples.packed || unknown) return;
  const auto there = static_cast<double>(size) - static_cast<double>(samples.begin);
  const double packed = samples.packed_size.value_or(there);
  if (!(packed > 0 && packed <= there))
    throw Error(ErrorCode::input, fmt::format("'{}' claims {} bytes of compressed samples and has {}; it is damaged or "
                                              "incomplete",
                                              file.string(), packed, there));
  std::ifstream in(samples.block, std::ios::binary);
  in.seekg(samples.begin);
  constexpr int either_header = 15 + 32;
  z_stream z{};
  if (inflateInit2(&z, either_header) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&z, inflateEnd);
  std::vector<unsigned char> from(1 << 18), to(1 << 18);
  auto left = static_cast<std::uint64_t>(packed);
  std::uint64_t got = 0;
  for (int state = Z_OK; state == Z_OK && got < bytes;) {
    if (z.avail_in == 0) {
      const auto part = std::min<std::uint64_t>(left, from.size());
      in.read(reinterpret_cast<char*>(from.data()), static_cast<std::streamsize>(part));
      z.next_in = from.data();
      z.avail_in = static_cast<unsigned>(in.gcount());
      left -= part;
    }
    z.next_out = to.data();
    z.avail_out = static_cast<unsigned>(to.size());
    state = inflate(&z, Z_NO_FLUSH);  // Z_BUF_ERROR where nothing is left to read
    got += to.size() - z.avail_out;
  }
  if (got < bytes)
    throw Error(ErrorCode::input,
                fmt::format("'{}' is damaged or incomplete: its compressed samples end after {} of {} "
                            "bytes",
                            file.string(), got, bytes));
}

bool is_meta(const std::string& extension) { return extension == ".mha" || extension == ".mhd"; }

template <class T>
std::vector<T> read_samples(ImageIO& io, const std::filesystem::path& file, const std::string& extension,
                            const Grid& grid, Context* context) {
  const std::uint64_t count = checked_sample_count(file, grid.dims, sizeof(T), bytes_available(file, extension));
  check_read_memory(file, count * sizeof(T), context);
  if (is_meta(extension)) check_packed_meta(file, count * sizeof(T));
  const unsigned axes = io.GetNumberOfDimensions();
  itk::ImageIORegion region(axes);
  for (unsigned a = 0; a < axes; ++a) {
    region.SetIndex(a, 0);
    region.SetSize(a, io.GetDimensions(a));
  }
  io.SetIORegion(region);
  if (static_cast<std::uint64_t>(io.GetImageSizeInBytes()) != count * sizeof(T))
    throw Error(ErrorCode::input, fmt::format("'{}' contradicts itself about its size", file.string()));
  std::vector<T> samples(count);
  io.Read(samples.data());
  return samples;
}

Volume::Samples read_typed(ImageIO& io, const std::filesystem::path& file, const std::string& extension,
                           const Grid& grid, Context* context) {
  const auto read = [&]<class T>(T) -> Volume::Samples { return read_samples<T>(io, file, extension, grid, context); };
  using Type = itk::IOComponentEnum;
  switch (io.GetComponentType()) {
    case Type::UCHAR:
      return read(std::uint8_t{});
    case Type::CHAR:
      return read(std::int8_t{});
    case Type::USHORT:
      return read(std::uint16_t{});
    case Type::SHORT:
      return read(std::int16_t{});
    case Type::UINT:
      return read(std::uint32_t{});
    case Type::INT:
      return read(std::int32_t{});
    case Type::ULONG:
      return sizeof(long) == 8 ? read(std::uint64_t{}) : read(std::uint32_t{});
    case Type::LONG:
      return sizeof(long) == 8 ? read(std::int64_t{}) : read(std::int32_t{});
    case Type::ULONGLONG:
      return read(std::uint64_t{});
    case Type::LONGLONG:
      return read(std::int64_t{});
    case Type::FLOAT:
      return read(float{});
    case Type::DOUBLE:
      return read(double{});
    default:
      throw Error(ErrorCode::input,
                  fmt::format("the samples of '{}' are of type {}; convert them to integers, float or double",
                              file.string(), ImageIO::GetComponentTypeAsString(io.GetComponentType())));
  }
}

/// On some damaged headers the libraries behind ITK abort, divide by zero or compute without end; a process of its own
/// tries it first. `samples`: also those of a MetaImage that names files, whose list is a part of the header. TIFF
/// headers have no such arithmetic, and a folder has thousands of them.
void try_apart(const std::filesystem::path& file, const std::string& extension, bool samples) {
  if (is_tiff(extension)) return;
  const bool all = samples && is_meta(extension) && !meta_samples(file).own;
  ApartLimits limits;
  if (all) {
    limits.bytes += available_memory();  // check_read_memory() is what limits it then
    limits.seconds += 2e-6 * static_cast<double>(bytes_available(file, extension) / deflate_limit);
  }
  const auto read = [&]() -> std::string {
    try {
      const auto io = image_io(extension);
      io->SetFileName(file.string());
      io->ReadImageInformation();
      if (all) read_typed(*io, file, extension, grid_of(*io, file), nullptr);
    } catch (const itk::ExceptionObject& e) {
      refuse_as_itk(file, e);
    }
    return {};
  };
  read_apart(file, read, limits);
}

/// Runs `read` and makes every exception of the libraries a sentence.
template <class Read>
auto refusing(const std::filesystem::path& file, const Read& read) {
  try {
    return read();
  } catch (const itk::ExceptionObject& e) {
    refuse_as_itk(file, e);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {
    throw Error(ErrorCode::input,
                fmt::format("'{}' cannot be read: its library fails on it; it is damaged", file.string()));
  }
}

}  // namespace

Volume read_itk(const std::filesystem::path& file, Context* context) {
  const std::string extension = volume_extension(file);
  itk::Object::SetGlobalWarningDisplay(false);
  checkpoint(context, "read", 0);
  if (extension.starts_with(".nii")) check_nifti_header(file);
  if (is_tiff(extension)) silence_libtiff();
  try_apart(file, extension, true);
  if (is_nrrd(extension)) check_nrrd_header(file);
  const QuietCerr quiet;
  return refusing(file, [&] {
    const auto io = image_io(extension);
    io->SetFileName(file.string());
    io->ReadImageInformation();
    Volume volume;
    volume.grid = grid_of(*io, file);
    if (is_tiff(extension)) {
      // Pages and slices have no distance, and dots per inch are seldom meant: one length for all three axes.
      if (!volume.grid.spacing.isApproxToConstant(1))
        note(context,
             fmt::format("'{}' gives a size of pixels but no distance of slices; the spacing is taken as 1 x 1 "
                         "x 1 (change it with --spacing)",
                         file.string()));
      volume.grid.spacing = Vec3::Ones();
      volume.grid.origin = Vec3::Zero();
    }
    if (extension.starts_with(".nii")) volume.units = "mm";  // ITK converts
    volume.samples = read_typed(*io, file, extension, volume.grid, context);
    checkpoint(context, "read", 1);
    return volume;
  });
}

std::optional<ItkHeader> itk_header(const std::filesystem::path& file, Context* context) {
  const std::string extension = volume_extension(file);
  if (extension.starts_with(".nii") || is_tiff(extension)) return {};
  itk::Object::SetGlobalWarningDisplay(false);
  checkpoint(context, "read", 0);
  try_apart(file, extension, false);
  if (is_nrrd(extension)) check_nrrd_header(file);
  const QuietCerr quiet;
  return refusing(file, [&]() -> std::optional<ItkHeader> {
    const auto io = image_io(extension);
    io->SetFileName(file.string());
    io->ReadImageInformation();
    ItkHeader header;
    header.grid = grid_of(*io, file);
    if (io->GetNumberOfDimensions() != 3) return {};
    using Type = itk::IOComponentEnum;
    const std::pair<Type, SampleType> types[] = {
        {Type::UCHAR, SampleType::uint8},   {Type::CHAR, SampleType::int8},     {Type::USHORT, SampleType::uint16},
        {Type::SHORT, SampleType::int16},   {Type::UINT, SampleType::uint32},   {Type::INT, SampleType::int32},
        {Type::FLOAT, SampleType::float32}, {Type::DOUBLE, SampleType::float64}};
    const auto known = std::find_if(std::begin(types), std::end(types),
                                    [&](const auto& t) { return t.first == io->GetComponentType(); });
    if (known == std::end(types)) return {};
    header.type = known->second;
    header.sample_size = io->GetComponentSize();
    if (is_meta(extension)) {
      const auto& dims = header.grid.dims;
      const std::uint64_t count =
          checked_sample_count(file, dims, header.sample_size, bytes_available(file, extension));
      check_packed_meta(file, count * header.sample_size);
    }
    if (io->CanStreamRead() && (extension != ".mha" || meta_samples(file).own))
      header.next_slice = [io, file, z = std::int64_t{0}](std::span<std::byte> slice) mutable {
        itk::ImageIORegion region(3);
        for (unsigned a = 0; a < 2; ++a) {
          region.SetIndex(a, 0);
          region.SetSize(a, io->GetDimensions(a));
        }
        region.SetIndex(2, z++);
        region.SetSize(2, 1);
        refusing(file, [&] {
          io->SetIORegion(region);
          if (region.GetNumberOfPixels() * io->GetComponentSize() != slice.size())
            throw Error(ErrorCode::input, fmt::format("'{}' contradicts itself about its size", file.string()));
          io->Read(slice.data());
        });
      };
    return header;
  });
}

}  // namespace quench::io
