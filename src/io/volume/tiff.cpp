// SPDX-License-Identifier: Apache-2.0
// TIFF volumes, one slice at a time: the pages of a file, the planes of a page, or the pictures behind its only page.
#include <fmt/format.h>

#include "io/volume/slice_streams.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"
#include "shape/sample_type.h"

#ifdef QUENCH_HAS_TIFF
#include <algorithm>
#include <bit>
#include <cmath>

#include "base/memory.h"
#include "base/text.h"
#include "io/volume/scaled_values.h"
#include "io/volume/tiff_page.h"

namespace quench::io {
namespace {

std::string kind_text(const TiffLayout& l) {
  const bool real = l.format == SAMPLEFORMAT_IEEEFP, is_signed = l.format == SAMPLEFORMAT_INT;
  return fmt::format("{} x {}{} pixels of {}{}{}", l.width, l.height, l.depth == 1 ? "" : fmt::format(" x {}", l.depth),
                     real        ? "float"
                     : is_signed ? "int"
                                 : "uint",
                     l.bits,
                     l.has_colours()    ? fmt::format(", {} per pixel", l.channels)
                     : l.colour_indices ? " with colours"
                                        : "");
}

class TiffVolume {
 public:
  TiffVolume(const std::filesystem::path& path, const VolumeReadOptions& options, Context* context, bool of_a_folder)
      : file_(path, context), context_(context), options_(options), of_a_folder_(of_a_folder) {
    const bool limited = context && context->memory_limit > 0;
    memory_ = limited ? context->memory_limit : base::available_memory();
    channel_ = channel_named(options.channel);
    find_pages();
    find_slices();
    check_channel();
    find_values();
    check_size(TiffPage(file_, pages_.front(), memory_));
  }

  TiffStream stream() const {
    TiffStream stream;
    const auto& l = layout_;
    stream.grid.dims = {l.transposed() ? l.height : l.width, l.transposed() ? l.width : l.height, slices_};
    stream.type = values_ ? values_->type(l.type) : l.type;
    stream.colour_indices = l.colour_indices;
    if (slices_ == 1) stream.grid.dimension = 2;
    if (slices_ == 1 && takes_channel()) stream.picture = TiffPage::kind_of_colours(l);
    TiffResolution resolution = resolution_;
    if (l.transposed()) std::swap(resolution.x, resolution.y);
    const bool plane = slices_ == 1 && !of_a_folder_ && options_.dimension != 3;
    const TiffCalibration calibration =
        plane ? tiff_plane_calibration(description_, resolution) : tiff_calibration(description_, resolution, slices_);
    stream.grid.spacing = calibration.spacing;
    stream.coordinates.units = calibration.units;
    stream.spacing_source = calibration.source;
    if (!calibration.note.empty() && !options_.spacing) say(calibration.note);
    return stream;
  }

  void next(std::span<std::byte> out) {
    if (values_) {
      samples_.resize(layout_.samples() * shape::size_of(layout_.type));
      next_samples(samples_);
      values_->apply(layout_.type, samples_, out);
    } else {
      next_samples(out);
    }
    ++z_;
  }

 private:
  void next_samples(std::span<std::byte> out) {
    if (raw_at_)
      next_raw(out);
    else if (layout_.depth > 1)
      next_plane(out);
    else
      next_page(out);
  }

  void say(const std::string& what) const { note(context_, fmt::format("'{}' {}", file_.path().string(), what)); }
  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(ErrorCode::input, fmt::format("'{}' {}", file_.path().string(), what));
  }

  // All pages but reduced copies and masks; they are alike.
  void find_pages() {
    const std::size_t count = file_.directories().size();
    std::vector<std::size_t> white_is_zero;
    for (std::size_t i = 0; i < count; ++i) {
      checkpoint(context_, "read", 0);
      const TiffPage page(file_, i, memory_);
      if (page.is_accessory()) continue;
      const TiffLayout layout = page.layout();
      if (layout.photometric == PHOTOMETRIC_MINISWHITE && layout.format != SAMPLEFORMAT_INT &&
          layout.format != SAMPLEFORMAT_IEEEFP)
        white_is_zero.push_back(i);
      if (pages_.empty()) {
        layout_ = layout;
        description_ = tiff_description(page.description());
        resolution_ = page.resolution();
      } else if (kind_text(layout) != kind_text(layout_) || layout.transposed() != layout_.transposed()) {
        refuse(fmt::format("is not one stack: page {} has {}, page {} {}; save the pages you mean on their own", i + 1,
                           kind_text(layout), pages_.front() + 1, kind_text(layout_)));
      }
      pages_.push_back(i);
    }
    if (pages_.empty()) refuse("has only reduced copies or masks of other pictures");
    if (pages_.size() < count)
      say(fmt::format("has {} pages, of which {} and left out", count,
                      base::counted(count - pages_.size(), "is a reduced copy or mask of another",
                                    "are reduced copies or masks of others")));
    say_inverted(white_is_zero);
    if (layout_.colour_indices && !channel_)
      say("has a palette of colours: the indices of the colours are taken as values");
  }

  /// Whether colours become one channel.
  bool takes_channel() const { return layout_.has_colours() || (layout_.colour_indices && channel_); }

  void check_channel() const {
    if (!takes_channel()) return check_channel_of_grey(file_.path(), "a grey picture", channel_);
    if (!channel_ && (slices_ > 1 || of_a_folder_))
      refuse_colours_of_slices(file_.path(), TiffPage::kind_of_colours(layout_), layout_.width, layout_.height);
  }

  /// The values of a plane that was read into `stored`.
  void convert(const TiffPage& page, const TiffLayout& layout, std::span<const std::byte> stored,
               std::span<std::byte> out) {
    if (!layout.has_colours()) page.convert(layout, stored, out);
    if (!takes_channel()) return;
    Pixels pixels = layout.has_colours() ? page.colours(layout, stored) : page.colours_of_indices(layout, out);
    const Volume values = volume_of(std::move(pixels), file_.path(), channel_, context_);
    std::visit(
        [&](const auto& samples) {
          const auto bytes = std::as_bytes(std::span(samples));
          if (layout.has_colours())
            TiffPage::turn(layout, bytes, out);
          else  // turned already
            std::copy(bytes.begin(), bytes.end(), out.begin());
        },
        values.samples);
  }

  void say_inverted(const std::vector<std::size_t>& pages) const {
    if (pages.empty()) return;
    if (pages.size() == pages_.size())
      say("says that 0 is white: its values are inverted, so that bright voxels have high values");
    else if (pages.size() == 1)
      note(context_, fmt::format("page {} of '{}' says that 0 is white; its values are inverted", pages.front() + 1,
                                 file_.path().string()));
    else
      note(context_,
           fmt::format("{} of '{}', the first of them page {}, say that 0 is white; their values are inverted",
                       base::counted(pages.size(), "page"), file_.path().string(), pages.front() + 1));
  }

  void find_slices() {
    const TiffPage page(file_, pages_.front(), memory_);
    check_description();
    slices_ = static_cast<std::int64_t>(pages_.size()) * layout_.depth;
    if (layout_.depth > 1) {
      if (pages_.size() > 1)
        refuse(
            fmt::format("has {} volumes of {} slices; save the one you mean on its own", pages_.size(), layout_.depth));
      raw_at_ = page.raw_planes(layout_, layout_.depth, true);
      if (!raw_at_ && !page.is_tiled() && !page.lists_strips_of_planes(layout_))
        refuse(
            fmt::format("has a page of {} planes in strips, but does not list all strips; it is damaged, or save it "
                        "as one page per slice",
                        layout_.depth));
    } else if (description_.images > slices_ && file_.directories().size() == 1 && description_.one_directory) {
      raw_at_ = page.raw_planes(layout_, static_cast<std::uint64_t>(description_.images), false);
      if (raw_at_) slices_ = description_.images;
    }
    compare_with_description();
  }

  /// ImageJ's calibration of grey values, which it follows in unsigned integers of 8 and 16 bits only.
  void find_values() {
    const TiffDescription& d = description_;
    const bool follows = layout_.format == SAMPLEFORMAT_UINT && (layout_.bits == 8 || layout_.bits == 16);
    if (!d.function || *d.function == kNoFunction || !follows || takes_channel()) return;
    const auto [intercept, slope] = d.line;
    const bool line = *d.function == kStraightLine && slope != 0 && std::isfinite(slope) && std::isfinite(intercept);
    if (line && intercept == 0 && slope == 1) return;
    const bool white = layout_.photometric == PHOTOMETRIC_MINISWHITE;
    if (!line || white)
      return say(
          fmt::format("has a calibration of grey values by ImageJ that is not followed, because {}: thresholds are of "
                      "the stored values; save it in ImageJ as 32 bits to have calibrated ones",
                      white ? "0 is white in it" : "it is not a straight line"));
    values_ = LinearValues{slope, intercept};
    say(fmt::format(
        "has grey values that ImageJ calibrated, {:.9g} {} {:.9g} x the stored ones; thresholds are of these",
        intercept, slope < 0 ? "-" : "+", std::abs(slope)));
  }

  // A stack that is longer than its description is whole.
  void compare_with_description() const {
    const TiffDescription& d = description_;
    const bool one_of_a_set = of_a_folder_ && slices_ == 1 && !d.one_directory;
    if (d.images == 0 || d.images == slices_ || one_of_a_set) return;
    if (d.images < slices_)
      return say(
          fmt::format("has {}, and its {} says {}; all are taken", base::counted(slices_, "slice"), d.name, d.images));
    refuse(fmt::format("says in its {} that it has {} slices and holds {}; {}", d.name, d.images, slices_,
                       d.several_files ? "the others are in other files of the data set, which are not read: save the "
                                         "stack as one file"
                                       : "it is incomplete, or its description is of another stack: save it again"));
  }

  void check_description() const {
    const TiffDescription& d = description_;
    const bool several = pages_.size() > 1 || layout_.depth > 1 || (d.one_directory && d.images > 1);
    if (!several) return;  // e.g. one slice of a set that is described as a whole
    if (d.channels > 1)
      refuse(
          fmt::format("has {} channels by its {}; save the one you mean on its own, e.g. in ImageJ with Image > "
                      "Color > Split Channels",
                      d.channels, d.name));
    if (d.times > 1)
      refuse(
          fmt::format("has {} points in time by its {}; save the one you mean on its own (or, if they are slices, say "
                      "so in ImageJ with Image > Properties)",
                      d.times, d.name));
    if (d.volumes > 1)
      refuse(fmt::format("has {} images by its {}; save the one you mean on its own", d.volumes, d.name));
  }

  void check_size(const TiffPage& page) {
    const std::uint64_t size = shape::size_of(values_ ? values_->type(layout_.type) : layout_.type);
    constexpr int kFax = 20;  // a blank line of a fax page takes one bit
    const std::uint64_t available = file_.size() >> (63 - kFax) ? ~std::uint64_t{0} : file_.size() << kFax;
    checked_sample_count(file_.path(), {layout_.width, layout_.height, slices_}, size, available);
    check_memory(page, layout_);
  }

  /// What a slice of this page takes; a page that takes no more than one before it is not looked at twice.
  void check_memory(const TiffPage& page, const TiffLayout& layout) {
    const std::uint64_t sample_bytes = layout.samples() * shape::size_of(layout.type);
    const std::uint64_t stored = layout.plane_bytes() * page.planes_together(layout);
    const std::uint64_t turned = layout.orientation == ORIENTATION_TOPLEFT ? 0 : sample_bytes;
    const std::uint64_t buffer = raw_at_ ? 0 : page.buffer_bytes(layout);
    const std::uint64_t colours = takes_channel() ? sample_bytes * std::max<std::uint64_t>(3, layout.channels) : 0;
    const std::uint64_t values = values_ ? layout.samples() * shape::size_of(values_->type(layout.type)) : 0;
    const std::uint64_t bytes = sample_bytes + stored + turned + buffer + colours + values;
    if (bytes <= checked_bytes_) return;
    check_read_memory(file_.path(), bytes, context_);
    checked_bytes_ = bytes;
  }

  void next_page(std::span<std::byte> out) {
    TiffPage page(file_, pages_.at(static_cast<std::size_t>(z_)), memory_);
    const TiffLayout layout = page.layout();  // packed, cut into tiles or turned in its own way
    check_memory(page, layout);
    stored_.resize(layout.plane_bytes());
    page.read_planes(layout, 0, stored_);
    convert(page, layout, stored_, out);
  }

  // Planes that are stored together are read together.
  void next_plane(std::span<std::byte> out) {
    if (!page_) page_ = std::make_unique<TiffPage>(file_, pages_.front(), memory_);
    const auto z = static_cast<std::uint32_t>(z_), together = page_->planes_together(layout_);
    const std::uint64_t plane = layout_.plane_bytes();
    if (z % together == 0) {
      stored_.resize(plane * std::min(together, layout_.depth - z));
      page_->read_planes(layout_, z, stored_);
    }
    convert(*page_, layout_, std::span(stored_).subspan(z % together * plane, plane), out);
  }

  void next_raw(std::span<std::byte> out) {
    if (!page_) page_ = std::make_unique<TiffPage>(file_, pages_.front(), memory_);
    stored_.resize(layout_.plane_bytes());
    if (file_.read(*raw_at_ + static_cast<std::uint64_t>(z_) * stored_.size(), stored_) != stored_.size())
      slices_end_early(file_.path(), z_, slices_);
    if (layout_.lowest_bit_first)
      TIFFReverseBits(reinterpret_cast<std::uint8_t*>(stored_.data()), static_cast<tmsize_t>(stored_.size()));
    const std::size_t size = layout_.bits / 8u;
    if (file_.big_endian() != (std::endian::native == std::endian::big))
      for (auto at = stored_.begin(); at < stored_.end(); at += static_cast<std::ptrdiff_t>(size))
        std::reverse(at, at + static_cast<std::ptrdiff_t>(size));
    convert(*page_, layout_, stored_, out);
  }

  TiffFile file_;
  Context* context_;
  VolumeReadOptions options_;
  std::optional<Channel> channel_;
  bool of_a_folder_;  // one of its slices
  std::int64_t memory_ = 0;
  std::vector<std::size_t> pages_;  // indices of directories
  TiffLayout layout_;               // of the first page
  TiffDescription description_;
  TiffResolution resolution_;
  std::int64_t slices_ = 0, z_ = 0;
  std::uint64_t checked_bytes_ = 0;      // the most that a page was found to take
  std::optional<std::uint64_t> raw_at_;  // slices are bytes of the file from here on
  std::unique_ptr<TiffPage> page_;       // where it has all slices
  std::vector<std::byte> stored_, samples_;
  std::optional<LinearValues> values_;  // what becomes of samples
};

}  // namespace

TiffStream open_tiff(const std::filesystem::path& file, const VolumeReadOptions& options, Context* context,
                     bool of_a_folder) {
  const auto volume = std::make_shared<TiffVolume>(file, options, context, of_a_folder);
  TiffStream stream = volume->stream();
  stream.next = [volume](std::span<std::byte> out) { volume->next(out); };
  return stream;
}

}  // namespace quench::io
#else
namespace quench::io {

TiffStream open_tiff(const std::filesystem::path& file, const VolumeReadOptions&, Context*, bool) {
  throw Error(ErrorCode::usage, fmt::format("'{}' cannot be read: TIFF needs a Quench built with libtiff 4.5 or newer "
                                            "(libtiff-dev); convert it to NRRD or .npy, or rebuild",
                                            file.string()));
}

}  // namespace quench::io
#endif
