// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>

#include "quench/io.h"
#include "quench/record.h"

/// One reader and one writer per format; read_record and write_record choose among them by extension.
namespace quench::io {

/// The bytes of a file, with its name for error sentences.
struct FileText {
  std::string name;
  std::string bytes;
};

/// Throws Error(failed) when the file cannot be opened or read, or when it takes more memory than the context allows
/// or, without a limit there, than is free: a device may have no end.
FileText load_file(const std::filesystem::path& file, Context* context);

/// The extension in lower case, with its dot.
std::string lower_extension(const std::filesystem::path& file);

/// A dataset in a file of HDF5.
struct Hdf5Name {
  std::filesystem::path file;
  std::string dataset;  ///< empty: not said
};

/// "v.h5" or "v.h5:/path/to/dataset" (.h5 .hdf5 .hdf .ims), by the name only; nothing for other names.
std::optional<Hdf5Name> hdf5_name(const std::filesystem::path& name);

/// A file of DICOM: .dcm .dicom .ima or, where the extension is of no other format, by the mark in the file.
bool is_dicom(const std::filesystem::path& file);

/// Whether a folder holds files of DICOM.
bool holds_dicom(const std::filesystem::path& folder);

Record read_ply(const FileText& file);
Record read_obj(const FileText& file);
Record read_off(const FileText& file);
Record read_stl(const FileText& file);
Record read_ma(const FileText& file);
Record read_vtp(const FileText& file);
/// Any format Assimp knows, by path: such files may refer to others. Only where built with Assimp.
Record read_with_assimp(const std::filesystem::path& file);

void write_ply(std::ostream& out, const Record& data, const WriteOptions& options);
void write_obj(std::ostream& out, const Record& data);
void write_ma(std::ostream& out, const Record& data);
void write_r(std::ostream& out, const Record& data);
void write_csv(std::ostream& out, const Record& data);
void write_vtp(std::ostream& out, const Record& data);
void write_vtu(std::ostream& out, const Record& data);
void write_stl(std::ostream& out, const Record& data);

/// Adds a cell of the kind that its number of corners says, whatever the format calls it: one is an isolated point, two
/// a line, more a polygon. Readers refuse a face without corners. Throws Error(input) naming
/// the file when the corners outgrow 32-bit offsets.
void add_cell(Record& data, std::span<const std::uint32_t> corners, const std::string& file);

/// Adds an isolated point for every point that no cell uses, with zeros in cell arrays: in formats of medial axes
/// without cells for points, such a point is a part of the axis.
void add_isolated_points(Record& data);

/// The values of the point array `radius`; throws Error(input) naming the format that needs them.
std::vector<double> required_radii(const Record& data, const char* format);

/// "SPACE=LPS" where the data say so, for a comment in formats without a field for it; Slicer reads it there.
std::string space_comment(const Record& data);

/// The nearest float; for a double beyond their range the largest finite one (a cast would be undefined).
float to_float(double value);

}  // namespace quench::io
