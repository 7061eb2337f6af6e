// SPDX-License-Identifier: Apache-2.0
// Series of DICOM, slice by slice, in a child process.
#include <fmt/format.h>

#include "io/volume/slice_streams.h"
#include "quench/error.h"

#ifdef QUENCH_HAS_GDCM
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <vector>

#include "base/natural_order.h"
#include "base/platform/child_process.h"
#include "base/text.h"
#include "io/common/formats.h"
#include "io/volume/child_slices.h"
#include "io/volume/dicom_file.h"
#include "io/volume/scaled_values.h"
#include "io/volume/stored_volume.h"
#include "io/volume/volume_formats.h"
#include "shape/sample_type.h"

namespace quench::io {
namespace {

// How far a slice may lie from where equal distances would put it: of a step, and of a pixel.
constexpr double kOffPlace = 0.1;

std::vector<std::filesystem::path> dicom_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (!name.starts_with('.') && name != "DICOMDIR" && is_dicom(it->path())) files.push_back(it->path());
  }
  if (error)
    throw Error(ErrorCode::failed, fmt::format("the folder '{}' cannot be read: {}", folder.string(), error.message()));
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
    return base::natural_less(a.filename().string(), b.filename().string());
  });
  return files;
}

/// A frame of a file of the series.
struct DicomSlice {
  std::size_t file = 0, frame = 0;
  double height = 0;  ///< along the normal of the slices
};

/// The type of rescaled values, and of what is not rescaled.
SampleType type_of_values(const std::vector<DicomFile>& files) {
  const DicomSamples& samples = files.front().samples;
  const double values = std::ldexp(1.0, samples.is_signed ? samples.stored - 1 : samples.stored);
  const double least = samples.is_signed ? -values : 0, most = values - 1;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  bool whole = true;
  for (const DicomFile& file : files)
    for (const DicomFrame& frame : file.frames) {
      whole = whole && frame.slope == std::floor(frame.slope) && frame.intercept == std::floor(frame.intercept);
      const auto [a, b] = std::minmax({frame.slope * least + frame.intercept, frame.slope * most + frame.intercept});
      low = std::min(low, a);
      high = std::max(high, b);
    }
  if (!whole) return samples.stored <= 16 ? SampleType::float32 : SampleType::float64;
  if (low == least && high == most) {
    const int bytes = samples.allocated / 8;
    if (samples.is_signed) return bytes == 1 ? SampleType::int8 : bytes == 2 ? SampleType::int16 : SampleType::int32;
    return bytes == 1 ? SampleType::uint8 : bytes == 2 ? SampleType::uint16 : SampleType::uint32;
  }
  return type_of_whole_numbers(low, high);
}

class DicomSeries {
 public:
  DicomSeries(std::filesystem::path path, const VolumeReadOptions& options, Context* context)
      : path_(std::move(path)), options_(options), context_(context) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path_, ignored))
      take_folder();
    else
      take_file();
    check_alike();
    for (std::size_t i = 0; i < files_.size(); ++i)
      for (std::size_t f = 0; f < files_[i].frames.size(); ++f) slices_.push_back({i, f});
    place();
    std::uint64_t most = 0;
    for (const DicomFile& file : files_) most = std::max<std::uint64_t>(most, file.frames.size());
    const std::uint64_t bytes = most * files_.front().frame_bytes();
    check_read_memory(path_, 3 * bytes, context_);  // as it is stored, and decompressed by two
    base::allow_memory(8 * bytes);
    type_ = type_of_values(files_);
  }

  SliceStream stream() const {
    SliceStream stream;
    stream.grid = grid_;
    stream.type = type_;
    stream.coordinates = coordinates_;
    stream.spacing_source = source_;
    return stream;
  }

  void next(std::span<std::byte> out) {
    const DicomSlice& slice = slices_[z_++];
    const DicomFile& file = files_[slice.file];
    if (slice.file != in_memory_) {
      checkpoint(context_, "read", 0);
      pixels_ = {};
      pixels_ = dicom_pixels(file);
      in_memory_ = slice.file;
    }
    const std::size_t size = file.frame_bytes();
    const DicomFrame& frame = file.frames[slice.frame];
    const auto stored = std::span(pixels_).subspan(slice.frame * size, size);
    const auto from = [&]<class S>(S) {
      shape::with_sample_type(type_, [&]<class T>(T) { rescale<S, T>(stored, out, frame); });
    };
    const DicomSamples& samples = file.samples;
    if (samples.allocated == 8) samples.is_signed ? from(std::int8_t{}) : from(std::uint8_t{});
    if (samples.allocated == 16) samples.is_signed ? from(std::int16_t{}) : from(std::uint16_t{});
    if (samples.allocated == 32) samples.is_signed ? from(std::int32_t{}) : from(std::uint32_t{});
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const { refuse_volume(path_, why); }
  void say(const std::string& what) const { note(context_, fmt::format("'{}' {}", path_.string(), what)); }

  /// "'IM7.dcm'", "frame 3 of 'IM7.dcm'".
  std::string name_of(const DicomSlice& slice) const {
    const DicomFile& file = files_[slice.file];
    const std::string name = fmt::format("'{}'", base::plain(file.file.filename().string()));
    return file.frames.size() == 1 ? name : fmt::format("frame {} of {}", slice.frame + 1, name);
  }
  const DicomFrame& frame_of(const DicomSlice& slice) const { return files_[slice.file].frames[slice.frame]; }

  void take_folder() {
    std::map<std::string, std::size_t> place;  // of a series in `all`
    std::vector<std::vector<DicomFile>> all;
    for (const auto& file : dicom_files(path_)) {
      checkpoint(context_, "read", 0);
      std::optional<DicomFile> header = dicom_header(file);
      if (!header) continue;
      const auto [at, is_new] = place.emplace(header->series, all.size());
      if (is_new) all.emplace_back();
      all[at->second].push_back(std::move(*header));
    }
    if (all.empty()) refuse("its files of DICOM hold no pictures");
    if (all.size() > 1) refuse_several(all);
    files_ = std::move(all.front());
  }

  [[noreturn]] void refuse_several(const std::vector<std::vector<DicomFile>>& all) const {
    constexpr std::size_t kMost = 8;
    std::string list;
    for (std::size_t i = 0; i < std::min(all.size(), kMost); ++i) {
      std::size_t slices = 0;
      for (const DicomFile& file : all[i]) slices += file.frames.size();
      const std::string& title = all[i].front().title;
      list += fmt::format("{}{}'{}' ({})", i == 0 ? "" : ", ", title.empty() ? title : title + ": ",
                          base::plain(all[i].front().file.filename().string()), base::counted(slices, "slice"));
    }
    if (all.size() > kMost) list += fmt::format(" and {} more", all.size() - kMost);
    refuse(fmt::format("it holds {} of DICOM: {}; give one file of the series you mean",
                       base::counted(all.size(), "series", "series"), list));
  }

  /// The file alone, or the series it is a slice of.
  void take_file() {
    std::optional<DicomFile> header = dicom_header(path_);
    if (!header) refuse("it holds no picture; give a file of pictures, or their folder");
    const bool alone = header->frames.size() > 1 || header->series.empty() || options_.dimension == 2;
    const std::string series = header->series;
    files_.push_back(std::move(*header));
    if (alone) return;
    std::error_code ignored;
    std::vector<DicomFile> all;
    const auto folder = path_.has_parent_path() ? path_.parent_path() : std::filesystem::path(".");
    for (const auto& file : dicom_files(folder)) {
      checkpoint(context_, "read", 0);
      if (std::filesystem::equivalent(file, path_, ignored)) {
        all.push_back(files_.front());
        continue;
      }
      std::optional<DicomFile> other;
      try {
        other = dicom_header(file);
      } catch (const Error&) {  // whether it belongs to the series cannot be known; a gap would show
        continue;
      }
      if (other && other->series == series) all.push_back(std::move(*other));
    }
    if (all.size() < 2) return;
    files_ = std::move(all);
    say(
        fmt::format("is one slice of a series of {} in its folder, which is read; to take it as an image, say that its "
                    "dimension is 2",
                    files_.size()));
  }

  void check_alike() const {
    const DicomFile& first = files_.front();
    const DicomSamples& s = first.samples;
    if (s.channels != 1 || !first.colours.starts_with("MONOCHROME"))
      refuse(fmt::format("its pixels have colours ({}); a volume has one value per voxel: save it with grey values",
                         first.colours.empty() ? "no interpretation given" : first.colours));
    if (s.allocated != 8 && s.allocated != 16 && s.allocated != 32)
      refuse(fmt::format("its pixels have {} bits; save it with 8, 16 or 32", s.allocated));
    for (const DicomFile& file : files_) {
      if (file.columns != first.columns || file.rows != first.rows || !(file.samples == s))
        refuse(fmt::format(
            "its slices are not alike: '{}' has {} x {} pixels of {} bits, '{}' {} x {} of {}; put those of "
            "one volume into a folder of their own",
            base::plain(first.file.filename().string()), first.columns, first.rows, s.stored,
            base::plain(file.file.filename().string()), file.columns, file.rows, file.samples.stored));
    }
    if (first.colours == "MONOCHROME1")
      say("is of the kind MONOCHROME1: what its pictures show bright has small values, which are taken as they are");
  }

  void place() {
    grid_.dims = {files_.front().columns, files_.front().rows, static_cast<std::int64_t>(slices_.size())};
    checked_sample_count(path_, grid_.dims,
                         files_.front().frame_bytes() / static_cast<std::uint64_t>(grid_.dims[0]) /
                             static_cast<std::uint64_t>(grid_.dims[1]),
                         std::uint64_t{1} << 62);
    if (slices_.size() == 1) grid_.dimension = 2;
    coordinates_.units = "mm";
    check_planes();
    const bool placed = std::all_of(slices_.begin(), slices_.end(), [&](const DicomSlice& slice) {
      return frame_of(slice).position && frame_of(slice).axes;
    });
    const double between = frame_of(slices_.front()).between.value_or(1);
    Mat3 steps = plane_steps();
    if (placed)
      sort_by_position();
    else if (slices_.size() > 1)
      sort_by_number();
    const DicomFrame& first = frame_of(slices_.front());
    if (placed && slices_.size() > 1)
      steps.col(2) = step_between_slices(steps);
    else
      steps.col(2) *= between;
    set_steps(path_, steps, "ImageOrientationPatient and the positions of the slices", grid_);
    if (first.position) grid_.origin = *first.position;
    if (first.axes && first.position) coordinates_.space = "LPS";
    if (slices_.size() > 1 && source_.empty() == false)
      source_ += placed ? " and the positions of the slices" : first.between ? " and the distance of slices" : "";
  }

  /// Checks that all slices have the plane and the pixels of the first.
  void check_planes() const {
    constexpr double kTurned = 1e-3, kPixel = 1e-3;
    const DicomFrame& first = frame_of(slices_.front());
    for (const DicomSlice& slice : slices_) {
      const DicomFrame& frame = frame_of(slice);
      bool same =
          frame.axes.has_value() == first.axes.has_value() && frame.pixel.has_value() == first.pixel.has_value();
      for (std::size_t a = 0; a < 2 && same; ++a) {
        if (first.axes) same = ((*frame.axes)[a] - (*first.axes)[a]).cwiseAbs().maxCoeff() <= kTurned;
        if (first.pixel) same = same && std::abs((*frame.pixel)[a] - (*first.pixel)[a]) <= kPixel * (*first.pixel)[a];
      }
      if (!same)
        refuse(
            fmt::format("its slices {} and {} have different orientations or sizes of pixels; put those of one volume "
                        "into a folder of their own",
                        name_of(slices_.front()), name_of(slice)));
    }
  }

  /// The steps along rows and columns, and the normal of the slices.
  Mat3 plane_steps() {
    const DicomFrame& first = frame_of(slices_.front());
    Mat3 steps = Mat3::Identity();
    if (first.axes) {
      steps.col(0) = (*first.axes)[0];
      steps.col(1) = (*first.axes)[1];
      steps.col(2) = steps.col(0).cross(steps.col(1)).stableNormalized();
    }
    const std::array<double, 2> pixel = first.pixel.value_or(std::array{1.0, 1.0});
    if (first.pixel) {
      source_ = files_.front().detector ? "ImagerPixelSpacing" : "PixelSpacing";
    } else {
      coordinates_.units.clear();
      if (!options_.spacing) say("does not say the size of its pixels, which is taken as 1");
    }
    for (int a = 0; a < 2; ++a) steps.col(a) *= pixel[static_cast<std::size_t>(a)];
    return steps;
  }

  void sort_by_number() {
    const bool files_sorted = files_.size() == 1;
    const auto number = [&](const DicomSlice& s) { return files_[s.file].number; };
    if (!files_sorted) {
      for (const DicomSlice& slice : slices_)
        if (!number(slice))
          refuse(fmt::format(
              "its slice {} has neither a position (ImagePositionPatient) nor a number (InstanceNumber); its "
              "slices cannot be sorted",
              name_of(slice)));
      std::stable_sort(slices_.begin(), slices_.end(),
                       [&](const DicomSlice& a, const DicomSlice& b) { return *number(a) < *number(b); });
      for (std::size_t i = 1; i < slices_.size(); ++i)
        if (slices_[i].file != slices_[i - 1].file && *number(slices_[i]) == *number(slices_[i - 1]))
          refuse(fmt::format("its slices {} and {} have no positions and the same number (InstanceNumber {})",
                             name_of(slices_[i - 1]), name_of(slices_[i]), *number(slices_[i])));
    }
    if (!options_.spacing)
      say(fmt::format(
          "has slices without a position (ImagePositionPatient): they are taken in the order of their numbers, "
          "{} apart",
          frame_of(slices_.front()).between
              ? fmt::format("{:.6g} mm (SpacingBetweenSlices or SliceThickness)", *frame_of(slices_.front()).between)
              : "1"));
  }

  void sort_by_position() {
    const auto& axes = *frame_of(slices_.front()).axes;
    const Vec3 normal = axes[0].cross(axes[1]).stableNormalized();
    for (DicomSlice& slice : slices_) slice.height = normal.dot(*frame_of(slice).position);
    std::stable_sort(slices_.begin(), slices_.end(),
                     [](const DicomSlice& a, const DicomSlice& b) { return a.height < b.height; });
    if (slices_.size() < 2) return;
    std::vector<double> gaps;
    for (std::size_t i = 1; i < slices_.size(); ++i) gaps.push_back(slices_[i].height - slices_[i - 1].height);
    std::vector<double> sorted = gaps;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    const double usual = sorted[sorted.size() / 2], longest = *std::max_element(gaps.begin(), gaps.end());
    for (std::size_t i = 0; i < gaps.size(); ++i)
      if (!(gaps[i] > 1e-3 * longest))
        refuse(fmt::format(
            "its slices {} and {} lie at the same place: there are several times, echoes or copies; put one "
            "set of slices into a folder of its own",
            name_of(slices_[i]), name_of(slices_[i + 1])));
    check_distances(gaps, usual);
  }

  /// Each slice must be near where equal distances between the first and the last would put it.
  void check_distances(const std::vector<double>& gaps, double usual) const {
    const double step = (slices_.back().height - slices_.front().height) / static_cast<double>(gaps.size());
    double worst = 0;
    for (std::size_t i = 0; i < slices_.size(); ++i)
      worst = std::max(worst, std::abs(slices_[i].height - slices_.front().height - step * static_cast<double>(i)));
    if (worst <= kOffPlace * step) return;
    const auto odd = std::max_element(gaps.begin(), gaps.end(),
                                      [&](double a, double b) { return std::abs(a - usual) < std::abs(b - usual); });
    const auto at = static_cast<std::size_t>(odd - gaps.begin());
    refuse(fmt::format(
        "its slices {} and {} are {:.6g} mm apart, others {:.6g}: {}; complete the series, or resample it to "
        "equal distances",
        name_of(slices_[at]), name_of(slices_[at + 1]), *odd, usual,
        *odd > 1.5 * usual ? "slices are missing between them" : "the distances are not equal"));
  }

  /// From one slice to the next. Along the normal where that puts the last slice in its place.
  Vec3 step_between_slices(const Mat3& steps) const {
    const Vec3 first = *frame_of(slices_.front()).position, all = *frame_of(slices_.back()).position - first;
    const auto count = static_cast<double>(slices_.size() - 1);
    const Vec3 normal = steps.col(2), step = all / count;
    const double pixel = std::min(steps.col(0).norm(), steps.col(1).norm());
    for (std::size_t i = 0; i < slices_.size(); ++i) {
      const Vec3 off = *frame_of(slices_[i]).position - first - step * static_cast<double>(i);
      if ((off - normal * normal.dot(off)).norm() > pixel / 2)
        refuse(fmt::format("its slice {} is shifted sideways from the line of the others; resample the series",
                           name_of(slices_[i])));
    }
    const double height = normal.dot(step);
    return (all - normal * normal.dot(all)).norm() <= kOffPlace * pixel ? Vec3(normal * height) : step;
  }

  template <class S, class T>
  static void rescale(std::span<const std::byte> stored, std::span<std::byte> out, const DicomFrame& frame) {
    const std::size_t count = stored.size() / sizeof(S);
    for (std::size_t i = 0; i < count; ++i) {
      S sample;
      std::memcpy(&sample, stored.data() + i * sizeof(S), sizeof(S));
      const auto value = static_cast<T>(frame.slope * static_cast<double>(sample) + frame.intercept);
      std::memcpy(out.data() + i * sizeof(T), &value, sizeof(T));
    }
  }

  std::filesystem::path path_;
  const VolumeReadOptions& options_;
  Context* context_;
  std::vector<DicomFile> files_;
  std::vector<DicomSlice> slices_;  // z ascending
  Grid grid_;
  Coordinates coordinates_;
  std::string source_;
  SampleType type_ = SampleType::uint8;
  std::size_t z_ = 0, in_memory_ = static_cast<std::size_t>(-1);
  std::vector<std::byte> pixels_;  // of one file
};

}  // namespace

SliceStream open_dicom(const std::filesystem::path& path, const VolumeReadOptions& options, Context* context) {
  const auto open = [&](Context* in_child) {
    const auto series = std::make_shared<DicomSeries>(path, options, in_child);
    SliceStream stream = series->stream();
    stream.next = [series](std::span<std::byte> out) { series->next(out); };
    return stream;
  };
  return slices_of_child(path, open, context);
}

}  // namespace quench::io
#else
namespace quench::io {

SliceStream open_dicom(const std::filesystem::path& path, const VolumeReadOptions&, Context*) {
  throw Error(ErrorCode::usage, fmt::format("'{}' cannot be read: DICOM needs a Quench built with GDCM (libgdcm-dev); "
                                            "convert it to NRRD or NIfTI, or rebuild",
                                            path.string()));
}

}  // namespace quench::io
#endif
