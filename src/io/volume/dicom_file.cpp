// SPDX-License-Identifier: Apache-2.0
#ifdef QUENCH_HAS_GDCM
#include "io/volume/dicom_file.h"

#include <fmt/format.h>
#include <gdcmImageHelper.h>
#include <gdcmImageReader.h>
#include <gdcmMediaStorage.h>
#include <gdcmReader.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string_view>

#include "base/text.h"
#include "io/common/words.h"
#include "io/volume/stored_volume.h"
#include "io/volume/volume_formats.h"

namespace quench::io {
namespace {

using gdcm::DataSet;
using gdcm::Tag;

using Sequence = gdcm::SmartPointer<gdcm::SequenceOfItems>;

constexpr std::int64_t kMostFrames = 1'000'000;

const Tag kPlace(0x0020, 0x9113), kPosition(0x0020, 0x0032);

/// The text of an element, without blanks at its ends; empty where there is none.
std::string text_of(const DataSet& set, const Tag& tag) {
  constexpr std::size_t kLongest = 4096;
  if (!set.FindDataElement(tag)) return {};
  const gdcm::ByteValue* value = set.GetDataElement(tag).GetByteValue();
  if (!value || !value->GetPointer()) return {};
  std::string text(value->GetPointer(), std::min<std::size_t>(value->GetLength(), kLongest));
  text.resize(std::min(text.find('\0'), text.size()));
  return std::string(trimmed(text));
}

/// The numbers of a text, separated by backslashes; nothing where they are not `count` finite ones.
std::optional<std::vector<double>> numbers_of(const std::string& text, std::size_t count) {
  std::vector<double> numbers;
  for (std::size_t at = 0; at <= text.size() && numbers.size() <= count;) {
    const std::size_t end = std::min(text.find('\\', at), text.size());
    double number = 0;
    if (!parse_number(trimmed(std::string_view(text).substr(at, end - at)), number) || !std::isfinite(number))
      return {};
    numbers.push_back(number);
    at = end + 1;
  }
  if (numbers.size() != count) return {};
  return numbers;
}

std::optional<double> number_of(const std::string& text) {
  const auto numbers = numbers_of(text, 1);
  if (!numbers) return {};
  return numbers->front();
}

Sequence sequence_of(const DataSet& set, const Tag& tag) {
  if (!set.FindDataElement(tag)) return {};
  Sequence sequence = set.GetDataElement(tag).GetValueAsSQ();
  return sequence && sequence->GetNumberOfItems() > 0 ? sequence : Sequence();
}

/// What a data set says of its frames.
class FrameData {
 public:
  explicit FrameData(const DataSet& set)
      : set_(set), of_each_(sequence_of(set, Tag(0x5200, 0x9230))), of_all_(sequence_of(set, Tag(0x5200, 0x9229))) {}

  /// Of a frame, counted from 0: in the item of `sequence` in its group or in that of all frames, else in the file.
  std::string text(std::size_t frame, const Tag& sequence, const Tag& tag) const {
    for (const auto& [groups, item] : {std::pair(&of_each_, frame), std::pair(&of_all_, std::size_t{0})}) {
      const std::string found = in_group(*groups, item, sequence, tag);
      if (!found.empty()) return found;
    }
    return text_of(set_, tag);
  }
  /// Whether each frame has a place of its own.
  bool has_places() const { return !in_group(of_each_, 0, kPlace, kPosition).empty(); }

 private:
  static std::string in_group(const Sequence& groups, std::size_t item, const Tag& sequence, const Tag& tag) {
    if (!groups || item >= groups->GetNumberOfItems()) return {};
    const Sequence inner = sequence_of(groups->GetItem(item + 1).GetNestedDataSet(), sequence);
    return inner ? text_of(inner->GetItem(1).GetNestedDataSet(), tag) : std::string();
  }

  const DataSet& set_;
  Sequence of_each_, of_all_;
};

DicomFrame frame_of(const FrameData& data, std::size_t f) {
  const Tag kOrientation(0x0020, 0x9116), kMeasures(0x0028, 0x9110), kTransformation(0x0028, 0x9145);
  DicomFrame frame;
  if (const auto p = numbers_of(data.text(f, kPlace, kPosition), 3)) frame.position = Vec3((*p)[0], (*p)[1], (*p)[2]);
  if (const auto d = numbers_of(data.text(f, kOrientation, Tag(0x0020, 0x0037)), 6))
    frame.axes = {Vec3((*d)[0], (*d)[1], (*d)[2]), Vec3((*d)[3], (*d)[4], (*d)[5])};
  if (const auto s = numbers_of(data.text(f, kMeasures, Tag(0x0028, 0x0030)), 2)) frame.pixel = {(*s)[1], (*s)[0]};
  frame.between = number_of(data.text(f, kMeasures, Tag(0x0018, 0x0088)));
  if (!frame.between) frame.between = number_of(data.text(f, kMeasures, Tag(0x0018, 0x0050)));
  if (frame.between && !(*frame.between > 0)) frame.between.reset();
  frame.slope = number_of(data.text(f, kTransformation, Tag(0x0028, 0x1053))).value_or(1);
  frame.intercept = number_of(data.text(f, kTransformation, Tag(0x0028, 0x1052))).value_or(0);
  if (frame.slope == 0) frame.slope = 1;  // written by programs that mean none
  return frame;
}

void read_frames(const DataSet& set, std::size_t count, DicomFile& result) {
  const FrameData data(set);
  for (std::size_t f = 0; f < count; ++f) {
    result.frames.push_back(frame_of(data, f));
    DicomFrame& frame = result.frames.back();
    if (f > 0 && !data.has_places()) frame.position.reset();  // that of the file is the first one's
    if (frame.pixel) continue;
    const auto detector = numbers_of(text_of(set, Tag(0x0018, 0x1164)), 2);
    if (!detector) continue;
    frame.pixel = {(*detector)[1], (*detector)[0]};
    result.detector = true;
  }
}

/// The bits that are stored, with their sign in those above them.
template <class T>
void extend_sign(std::span<std::byte> bytes, int stored) {
  const int unused = static_cast<int>(8 * sizeof(T)) - stored;
  for (std::size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T)) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    value = static_cast<T>(static_cast<T>(static_cast<std::make_unsigned_t<T>>(value) << unused) >> unused);
    std::memcpy(bytes.data() + at, &value, sizeof value);
  }
}

void clean_bits(std::span<std::byte> bytes, const DicomSamples& samples) {
  if (samples.stored >= samples.allocated || samples.stored < 1) return;
  const auto extend = [&]<class T>(T) { extend_sign<T>(bytes, samples.stored); };
  if (samples.allocated == 8) samples.is_signed ? extend(std::int8_t{}) : extend(std::uint8_t{});
  if (samples.allocated == 16) samples.is_signed ? extend(std::int16_t{}) : extend(std::uint16_t{});
  if (samples.allocated == 32) samples.is_signed ? extend(std::int32_t{}) : extend(std::uint32_t{});
}

void be_silent() {
  gdcm::Trace::DebugOff();
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
}

DicomSamples samples_of(const gdcm::PixelFormat& format) {
  return {format.GetBitsAllocated(), format.GetBitsStored(), format.GetPixelRepresentation() == 1,
          format.GetSamplesPerPixel()};
}

/// Whether compressed pixels come to their end: the mark behind the last of their pieces.
bool has_end_of_pieces(const std::filesystem::path& file, std::uint64_t begin, std::uint64_t size) {
  constexpr std::uint64_t kFarthest = 1 << 16;  // from the end of the file: little follows the pixels
  constexpr std::string_view kMark("\xFE\xFF\xDD\xE0\0\0\0\0", 8);
  std::string end(std::min(kFarthest, size - std::min(begin, size)), '\0');
  std::ifstream in(file, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(size - end.size()));
  in.read(end.data(), static_cast<std::streamsize>(end.size()));
  return in && end.find(kMark) != end.npos;
}

/// Throws where the pixels, which begin at `begin`, are more than the file holds. GDCM would take them as 0.
void check_end(const gdcm::File& contents, std::uint64_t begin, double frames, const DicomFile& file) {
  const gdcm::TransferSyntax& syntax = contents.GetHeader().GetDataSetTransferSyntax();
  const std::uint64_t size = std::filesystem::file_size(file.file);
  if (syntax == gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian) return;  // known when it is read
  if (syntax.IsEncapsulated()
          ? has_end_of_pieces(file.file, begin, size)
          : static_cast<double>(begin) + frames * static_cast<double>(file.frame_bytes()) <= static_cast<double>(size))
    return;
  refuse_volume(file.file, fmt::format("it is too short for {} x {} pixels in {} frames; it is damaged or incomplete",
                                       file.columns, file.rows, frames));
}

/// Whether there are pixels for all frames; GDCM takes what is missing as 0.
bool holds_frames(const gdcm::DataElement& pixels, std::size_t frames, std::uint64_t size) {
  if (const gdcm::ByteValue* raw = pixels.GetByteValue()) return raw->GetLength() >= size;
  const gdcm::SequenceOfFragments* fragments = pixels.GetSequenceOfFragments();
  return fragments && fragments->GetNumberOfFragments() >= frames;
}

}  // namespace

std::optional<DicomFile> dicom_header(const std::filesystem::path& file) {
  { const InputFile there(file); }  // or its sentence
  be_silent();
  gdcm::Reader reader;
  reader.SetFileName(file.c_str());
  const Tag pixels(0x7fe0, 0x0010);
  if (!reader.ReadUpToTag(pixels, {pixels}))
    refuse_volume(file, "it is not a file of DICOM, or it is damaged or incomplete; copy or download it again");
  const DataSet& set = reader.GetFile().GetDataSet();
  if (!set.FindDataElement(Tag(0x0028, 0x0010)) || !set.FindDataElement(Tag(0x0028, 0x0011))) {
    gdcm::MediaStorage kind;
    kind.SetFromFile(reader.GetFile());
    if (!gdcm::MediaStorage::IsImage(kind)) return {};
    refuse_volume(file, "it does not say the size of its picture; it is damaged or incomplete");
  }
  DicomFile result;
  result.file = file;
  result.series = text_of(set, Tag(0x0020, 0x000e));
  result.title = text_of(set, Tag(0x0020, 0x0011));
  if (const std::string description = text_of(set, Tag(0x0008, 0x103e)); !description.empty())
    result.title = fmt::format("{}{}{}", result.title, result.title.empty() ? "" : " ", description.substr(0, 60));
  result.title = base::plain(result.title);
  result.colours = base::plain(text_of(set, Tag(0x0028, 0x0004)).substr(0, 40));
  result.number = number_of(text_of(set, Tag(0x0020, 0x0013)));
  const std::vector<unsigned> dims = gdcm::ImageHelper::GetDimensionsValue(reader.GetFile());
  if (dims.size() < 2) return {};
  result.columns = dims[0];
  result.rows = dims[1];
  result.samples = samples_of(gdcm::ImageHelper::GetPixelFormatValue(reader.GetFile()));
  const double frames = number_of(text_of(set, Tag(0x0028, 0x0008))).value_or(1);
  if (!(frames >= 1 && frames <= static_cast<double>(kMostFrames)) || frames != std::floor(frames))
    refuse_volume(file, fmt::format("it claims {} frames; it is damaged", frames));
  check_end(reader.GetFile(), reader.GetStreamCurrentPosition(), frames, result);
  read_frames(set, static_cast<std::size_t>(frames), result);
  return result;
}

std::vector<std::byte> dicom_pixels(const DicomFile& file) {
  be_silent();
  gdcm::ImageReader reader;
  reader.SetFileName(file.file.c_str());
  if (!reader.Read())
    refuse_volume(file.file, "its pixels are damaged or incomplete, or compressed in a way GDCM does not know");
  const gdcm::Image& image = reader.GetImage();
  const std::uint64_t size = file.frame_bytes() * file.frames.size();
  DicomSamples found = samples_of(image.GetPixelFormat());
  found.stored = file.samples.stored;
  if (image.GetBufferLength() != size || found != file.samples)
    refuse_volume(file.file, "its pixels are not those its header describes; it is damaged");
  std::vector<std::byte> bytes(size);
  if (!holds_frames(image.GetDataElement(), file.frames.size(), size) ||
      !image.GetBuffer(reinterpret_cast<char*>(bytes.data())))
    refuse_volume(file.file, "its pixels are damaged or incomplete, or compressed in a way GDCM does not know");
  clean_bits(bytes, file.samples);
  return bytes;
}

}  // namespace quench::io
#endif
