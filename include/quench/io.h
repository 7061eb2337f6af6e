// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "quench/context.h"
#include "quench/record.h"
#include "quench/shape.h"

/// Files. The extension chooses the format:
///
///   format                         surface in  axis in  axis out  volume in  volume out
///   .ply (ascii, binary LE/BE)          x         x        x
///   .obj (v, l, f)                      x         x        x
///   .off                                x         x
///   .stl (ascii, binary)                x
///   .vtp (XML PolyData)                 x         x        x
///   .ma  (nV nE nF; v, e, f)                      x        x
///   .r   (x y z r per vertex)                read_radii()  x
///   .csv (one row per vertex)                              x
///   .fbx .dae .3ds .gltf ... (Assimp)   x
///   .nrrd .nhdr .mha .mhd .nii .nii.gz .mrc .map                       x
///   .tif, a folder of TIFF slices (libtiff)                            x
///   a folder of OME-Zarr, Zarr or N5 (libzstd, libblosc)               x
///   .npy  .vol (DGtal)  .sof  .out  .png, a folder of PNG slices       x
///   .pbm .pgm .ppm .pnm  .bmp  .jpg .jpeg (libjpeg)                    x
///   .h5 .hdf5 .hdf .ims (libhdf5), also .h5:/path/to/dataset           x
///   DICOM, a file or a folder (GDCM)                                   x
///   .nrrd (gzip), .zarr (a folder: OME-Zarr 0.4)                                  x
///   .nrrd .nii .nii.gz .tif .npy of numbers (write_values())                      x
///
/// Polygons of the plane (.geojson .json .geojsonl .geojsons .ndjson .wkt .svg) are read by the functions of
/// quench/polygons.h; lines of the plane are written in these formats by those of quench/graph.h.
///
/// Curve graphs (.swc, .graphml, .csv) are written by the functions of quench/graph.h, trees (.swc, .rsml, ...) read
/// and written by those of quench/tree.h.
///
/// Every reader throws Error(failed) when the file cannot be opened and Error(input) when its content cannot be used,
/// naming the file and, where there is one, the line or byte. Every writer writes a temporary file in the same folder,
/// waits until it is on the disk and renames it: neither an interrupted run nor a power cut leaves a half file or harms
/// an existing one.
namespace quench::io {

enum class Kind { surface, volume, polygons, unknown };

/// By extension, for a folder by its content. Only files whose extension says nothing are opened, for the mark of
/// DICOM.
Kind kind_of(const std::filesystem::path& file);

/// What is on the disk under the name of an input: where there is no such file, the part of the name before a colon, as
/// of `scan.zarr:c=1`; the name itself where that is not there either.
std::filesystem::path place_of_input(const std::filesystem::path& file);

/// .ply .obj .off .stl .vtp .ma and, where built with Assimp, its formats. Arrays the format carries are kept by name
/// (`radius` and `quality` of PLY, r of .ma, all arrays of VTP). STL corners are welded by exact position. What a
/// format calls a face becomes a point, a line or a polygon by its number of corners (1, 2, more) in every format; a
/// face without corners is an error. `context` bounds the memory.
Record read_record(const std::filesystem::path& file, Context* context = nullptr);

/// .vtp .vtu .ply .obj .stl .ma .r .csv. STL carries polygons only, OBJ a group for each sheet of parts. PLY carries `quality` (= `radius` unless `quality_array` names another point array) and
/// colours; formats that cannot carry an array leave it out.
struct WriteOptions {
  std::string quality_array = "radius";
};
void write_record(const std::filesystem::path& file, const Record& data, const WriteOptions& options = {});
/// Throws Error(usage) for any other extension: to be called before a long computation.
void check_writable_format(const std::filesystem::path& file);

/// Values of a .r file for the given points: matched by nearest point, at most 1e-3 of the longest side away, else
/// Error(input).
std::vector<double> read_radii(const std::filesystem::path& file, const std::vector<Vec3>& points,
                               Context* context = nullptr);

/// `spacing` overrides what the file says (formats without spacing: 1). A folder is read in natural order (2 before
/// 10), one slice per file; numbered slices with a number missing or occurring twice, or with another file among
/// them, are Error(input).
///
/// What a PNG, PGM, PBM, PPM, BMP or JPEG file, a TIFF file of one page, or an array or image of two dimensions (NPY,
/// NRRD, MetaImage, NIfTI) holds is a plane (Grid::dimension 2), whose y is down. A volume of one slice may be meant as
/// either: without `dimension` it is Error(usage), field `dimension`.
///
/// Colours become one value per pixel. Luminance is (19595 red + 38470 green + 7471 blue) / 2^16 (ITU-R BT.601), what
/// is transparent composed on white, each rounded. Slices with colours need a channel: without one Error(input), field
/// `channel`.
struct VolumeReadOptions {
  /// The third number is 0 where there are two: for planes. A plane takes no third number of its own, a volume needs
  /// one: Error(usage), field `spacing`.
  std::optional<Vec3> spacing;
  std::optional<int> dimension = {};  ///< 2 or 3: what one slice is
  /// Of a picture with colours: "luminance", "alpha", "red", "green", "blue"; empty: alpha where all that is seen has
  /// one colour and alpha varies, else luminance. Of grey values all but alpha are the value.
  std::string channel = {};
};
Volume read_volume(const std::filesystem::path& file, const VolumeReadOptions& options = {},
                   Context* context = nullptr);

/// uint8 0/1, never dense in memory. NRRD, gzip, with spacing, origin and direction, of a plane also with `y_axis`; for
/// `.zarr` what write_zarr() writes, axes that go down turned round with their voxels.
void write_volume(const std::filesystem::path& file, const VoxelShape& shape, const Coordinates& coordinates = {},
                  Context* context = nullptr);

/// Takes the slices of a volume in ascending order of z: dims[0] * dims[1] numbers each, x fastest.
using VolumeSlices = std::function<void(const std::function<void(std::span<const float> slice)>& take)>;

/// Numbers of single precision on a grid, one slice after the other, which `slices` hands over all: NRRD (gzip),
/// NIfTI-1 (also gzip; its coordinates grow to the right and front, those of `grid` to the left and back), TIFF (a page
/// per slice, with the description of ImageJ; BigTIFF above 4 GB), NPY (x is the first axis of three, the second of
/// two). TIFF has no origin and no direction, NPY no spacing either. Atomically. Throws Error(usage) for another
/// extension.
void write_values(const std::filesystem::path& file, const Grid& grid, const VolumeSlices& slices,
                  const Coordinates& coordinates = {}, Context* context = nullptr);
/// Throws Error(usage) for an extension that write_values() does not take.
void check_value_format(const std::filesystem::path& file);

/// Side of the chunks of a Zarr volume.
inline constexpr std::int64_t kZarrSide = 128;

/// The samples of the chunk of which voxel `begin` is the least: kZarrSide^3, x fastest, background beyond the volume;
/// none: all are background. Called by several threads at a time.
using ZarrChunk = std::function<std::vector<std::uint8_t>(const std::array<std::int64_t, 3>& begin)>;

/// Writes a volume of bytes as OME-Zarr (NGFF 0.4, Zarr v2, one level, zlib), chunk by chunk on all threads: a chunk
/// and what it was compressed to per thread are in memory. Chunks of background are left out, as its fill value. The
/// folder appears when it is complete. In the place of a Zarr it replaces all of it, as check_zarr_output() says.
///
/// The format has spacing, origin and units, the space of `coordinates` is lost. Throws Error(usage) for a plane and
/// for a grid whose directions are not those of the axes.
void write_zarr(const std::filesystem::path& folder, const Grid& grid, std::uint8_t background, const ZarrChunk& chunk,
                const Coordinates& coordinates = {}, Context* context = nullptr);

/// Whether a path is called `.zarr`, with or without a slash behind it.
bool is_zarr_name(const std::filesystem::path& path);

/// Throws Error(usage) unless a Zarr may be written here: nothing is there, or a folder in which there are only files
/// of a Zarr (its metadata, chunks, folders of these, none of them protected against writing). A folder with anything
/// else in it is never replaced.
void check_zarr_output(const std::filesystem::path& folder);

/// Writes through `body` to a temporary file beside `file`, of a name that cannot be guessed and with the permissions
/// of the file it replaces, flushes it to the disk and renames it over `file`. What a link names is replaced, not the
/// link. On an exception the temporary file is removed and `file` is as it was. Throws Error(failed) when writing fails
/// (e.g. disk full).
void write_atomically(const std::filesystem::path& file, const std::function<void(std::ostream&)>& body);

/// A volume or image as slices where its format allows it: NRRD with its samples in the same file, raw or gzip;
/// uncompressed MetaImage and MRC; .out; TIFF; HDF5; DICOM; Zarr and N5; folders of slices. Nothing for other files:
/// read_volume() reads them whole. Throws as read_volume() does.
std::optional<SliceStream> open_slices(const std::filesystem::path& file, const VolumeReadOptions& options = {},
                                       Context* context = nullptr);

/// Files that appear together. While a group lives, what its thread writes through write_atomically() (every writer of
/// the library does) stays in temporary files beside the real ones; commit() renames them all. Without commit(), e.g.
/// on an exception, they are removed, and every file is as it was. Groups do not nest.
class OutputGroup {
 public:
  OutputGroup();
  OutputGroup(const OutputGroup&) = delete;
  OutputGroup& operator=(const OutputGroup&) = delete;
  ~OutputGroup();

  /// Throws Error(failed) at the first file that cannot be renamed, naming it; files written before it are complete and
  /// in place, later ones as they were.
  void commit();

  /// Bytes of a file written in this group, or of the file of that name; 0 when there is none.
  std::uintmax_t size_of(const std::filesystem::path& file) const;

 private:
  friend struct PostponedRename;
  struct Pending {
    std::filesystem::path temporary, target, name;
    int place;  // of the name of the temporary file or folder, for remove_temporary_files()
  };
  /// Removes what has not been put in place, and folders in whose place something was put.
  void discard();
  std::vector<Pending> pending_;
};

/// Removes the temporary files of all outputs that are not in place yet, of up to 64. For handlers of signals that end
/// the process at once: it neither allocates nor waits, and outputs being written are lost.
void remove_temporary_files() noexcept;

/// Which outputs of a process have replaced their files.
enum class Outputs {
  untouched,      ///< every file is as it was
  being_renamed,  ///< the files of a group are just being replaced, one after the other
  in_place        ///< some outputs have replaced their files
};

/// To be called before the process is ended without waiting for its threads: from now on no output is renamed, and
/// committing or writing one throws Error(cancelled). While outputs are being renamed, which is short, it changes
/// nothing and returns being_renamed; call it again then.
Outputs stop_outputs() noexcept;

/// The file that writing to `file` replaces or makes: the one at the end of its links, which need not exist.
std::filesystem::path place_of_output(const std::filesystem::path& file);

}  // namespace quench::io
