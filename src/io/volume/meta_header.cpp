// SPDX-License-Identifier: Apache-2.0
// MetaImage headers (.mha, .mhd), as ITK's MetaIO writes and reads them. World coordinates are those of ITK:
// left-posterior-superior.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "base/text.h"
#include "io/common/words.h"
#include "io/volume/data_files.h"
#include "io/volume/stored_volume.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

class MetaHeader {
 public:
  explicit MetaHeader(const std::filesystem::path& file) : file_(file), input_(file) {
    constexpr int kMostLines = 1000;
    std::string line;
    int lines = 0;
    for (; lines < kMostLines && !fields_.contains("ElementDataFile") && next_header_line(input_.stream, file_, line);
         ++lines)
      parse(line);
    if (!fields_.contains("ElementDataFile"))
      refuse(
          "its header does not say where the samples are (ElementDataFile); it is not a MetaImage, or it is damaged");
    begin_ =
        !input_.stream ? input_.size : static_cast<std::uint64_t>(static_cast<std::streamoff>(input_.stream.tellg()));
  }

  StoredVolume volume(Context* context);

 private:
  [[noreturn]] void refuse(const std::string& why) const { refuse_volume(file_, why); }
  static std::string shown(std::string_view text) { return base::plain(std::string(text.substr(0, 60))); }

  void parse(const std::string& line) {
    const std::size_t separator = line.find_first_of("=:");
    if (separator == std::string::npos) {
      if (!trimmed(line).empty()) refuse(fmt::format("a line of its header has no '=': '{}'", shown(line)));
      return;
    }
    const std::string name(trimmed(std::string_view(line).substr(0, separator)));
    const std::string value(trimmed(std::string_view(line).substr(separator + 1)));
    if (!fields_.emplace(name, value).second && name != "Comment")
      refuse(fmt::format("its header has the field '{}' twice", shown(name)));
  }

  /// The value of the first of the names that the header has.
  const std::string* field(std::initializer_list<const char*> names) const {
    for (const char* name : names)
      if (const auto found = fields_.find(name); found != fields_.end()) return &found->second;
    return nullptr;
  }
  bool flag(std::initializer_list<const char*> names, bool otherwise) const {
    const std::string* text = field(names);
    if (!text || text->empty()) return otherwise;
    const char first = (*text)[0];
    if (std::string_view("TtFf10").find(first) == std::string_view::npos)
      refuse(fmt::format("its field {} is '{}', neither True nor False", *names.begin(), shown(*text)));
    return first == 'T' || first == 't' || first == '1';
  }
  std::int64_t integer(const char* name, std::int64_t otherwise) const {
    const std::string* text = field({name});
    std::int64_t value = otherwise;
    if (text && !parse_integer(*text, value)) refuse(fmt::format("its field {} is '{}'", name, shown(*text)));
    return value;
  }
  std::vector<double> numbers(std::initializer_list<const char*> names, std::size_t count) const {
    const std::string* text = field(names);
    if (!text) return {};
    std::vector<double> values;
    for (const std::string_view word : words_of(*text)) {
      double value = 0;
      if (!parse_number(word, value) || !std::isfinite(value))
        refuse(fmt::format("its field {} has the entry '{}', which is not a number", *names.begin(), shown(word)));
      values.push_back(value);
    }
    if (values.size() != count)
      refuse(fmt::format("its field {} has {} entries where {} are needed", *names.begin(), values.size(), count));
    return values;
  }

  void set_grid(StoredVolume& volume) const;
  void set_type(StoredVolume& volume) const;
  void set_blocks(StoredVolume& volume, Context* context);
  std::vector<std::string> rest_of_lines();

  std::filesystem::path file_;
  InputFile input_;
  std::uint64_t begin_ = 0;  ///< of what follows the header
  std::map<std::string, std::string> fields_;
};

void MetaHeader::set_grid(StoredVolume& volume) const {
  if (const std::string* object = field({"ObjectType"}); object && *object != "Image")
    refuse(fmt::format("it is an object of type '{}', not an image", shown(*object)));
  const std::int64_t axes = integer("NDims", 0);
  if (axes < 1 || axes > 10) refuse(fmt::format("it has {} axes; a volume has three", axes));
  const auto n = static_cast<std::size_t>(axes);
  const std::string* sizes = field({"DimSize"});
  if (!sizes) refuse("its header has no field DimSize");
  const auto words = words_of(*sizes);
  if (words.size() != n) refuse(fmt::format("it has {} sizes for {} axes", words.size(), n));
  Grid& grid = volume.grid;
  grid.dims.fill(1);
  for (std::size_t a = 0; a < n; ++a) {
    std::int64_t size = 0;
    if (!parse_integer(words[a], size)) refuse(fmt::format("its field DimSize has the entry '{}'", shown(words[a])));
    if (a < 3) grid.dims[a] = size;
    if (a >= 3 && size != 1)
      refuse(fmt::format("it is an image of {} dimensions with {} volumes; save the one you mean on its own", n, size));
  }
  if (n == 2) grid.dimension = 2;
  const std::size_t used = std::min<std::size_t>(n, 3);
  std::vector<double> spacing = numbers({"ElementSpacing"}, n);
  if (spacing.empty()) spacing = numbers({"ElementSize"}, n);
  if (!spacing.empty()) volume.spacing_source = "the ElementSpacing of the header";
  const std::vector<double> origin = numbers({"Offset", "Position", "Origin"}, n);
  const std::vector<double> matrix = numbers({"TransformMatrix", "Rotation", "Orientation"}, n * n);
  Mat3 steps = Mat3::Identity();
  for (std::size_t a = 0; a < used; ++a) {
    const auto i = static_cast<int>(a);
    for (std::size_t row = 0; row < used && !matrix.empty(); ++row)  // a row of the matrix is the direction of an axis
      steps(static_cast<int>(row), i) = matrix[a * n + row];
    if (!matrix.empty() && !(std::abs(steps.col(i).stableNorm() - 1) < 1e-3))
      refuse(fmt::format("its TransformMatrix is not a rotation: the direction of axis {} has the length {:.6g}", a,
                         steps.col(i).stableNorm()));
    if (!spacing.empty()) steps.col(i) *= spacing[a];
    if (!origin.empty()) grid.origin[i] = origin[a];
  }
  set_steps(file_, steps, "ElementSpacing and TransformMatrix", grid);
  for (std::size_t a = 0; a < used && !spacing.empty(); ++a)  // to the last bit
    grid.spacing[static_cast<int>(a)] = std::abs(spacing[a]);
  if (const std::string* unit = field({"DistanceUnits"}); unit && *unit != "?") volume.coordinates.units = shown(*unit);
  volume.coordinates.space = "LPS";
}

void MetaHeader::set_type(StoredVolume& volume) const {
  if (const std::int64_t channels = integer("ElementNumberOfChannels", 1); channels != 1)
    refuse(
        fmt::format("it has {} values per voxel where one is needed; convert it to grey values or labels", channels));
  const std::string* type = field({"ElementType"});
  if (!type) refuse("its header has no field ElementType");
  const std::pair<const char*, SampleType> types[] = {
      {"MET_CHAR", SampleType::int8},     {"MET_UCHAR", SampleType::uint8},     {"MET_ASCII_CHAR", SampleType::int8},
      {"MET_SHORT", SampleType::int16},   {"MET_USHORT", SampleType::uint16},   {"MET_INT", SampleType::int32},
      {"MET_UINT", SampleType::uint32},   {"MET_LONG", SampleType::int32},  // four bytes in every file
      {"MET_ULONG", SampleType::uint32},  {"MET_LONG_LONG", SampleType::int64}, {"MET_ULONG_LONG", SampleType::uint64},
      {"MET_FLOAT", SampleType::float32}, {"MET_DOUBLE", SampleType::float64}};
  const auto known = std::find_if(std::begin(types), std::end(types), [&](const auto& t) { return t.first == *type; });
  if (known == std::end(types))
    refuse(fmt::format("its samples are of type '{}'; convert them to integers, float or double", shown(*type)));
  volume.type.type = known->second;
  const bool native_msb = std::endian::native == std::endian::big;
  volume.swapped = flag({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"}, native_msb) != native_msb;
}

std::vector<std::string> MetaHeader::rest_of_lines() {
  std::vector<std::string> names;
  for (std::string line; names.size() <= kMostDataFiles && next_header_line(input_.stream, file_, line);)
    if (const auto name = trimmed(line); !name.empty()) names.emplace_back(name);
  return names;
}

void MetaHeader::set_blocks(StoredVolume& volume, Context* context) {
  const bool binary = flag({"BinaryData"}, true), packed = flag({"CompressedData"}, false);
  if (packed && !binary) refuse("its samples are both compressed and text");
  volume.encoding = packed ? Encoding::deflate : binary ? Encoding::raw : Encoding::text;
  const std::string& where = fields_.at("ElementDataFile");
  const bool own = where == "LOCAL" || where == "Local" || where == "local";
  if (own)
    volume.blocks.push_back({file_, begin_, 0, {}});
  else
    volume.blocks =
        named_data_files(file_, where, lower(where).starts_with("list") ? rest_of_lines() : std::vector<std::string>(),
                         static_cast<std::size_t>(integer("NDims", 0)), "ElementDataFile");
  std::error_code error;
  for (const SampleBlock& block : volume.blocks)
    if (!own && std::filesystem::equivalent(block.file, file_, error))
      refuse("it names itself as the file of its samples (ElementDataFile); a file that has both says LOCAL there");

  double bytes = static_cast<double>(volume.type.size()) / static_cast<double>(volume.blocks.size());
  for (const std::int64_t side : volume.grid.dims) bytes *= static_cast<double>(side);
  const std::int64_t header = integer("HeaderSize", 0);
  if (header < -1) refuse(fmt::format("its field HeaderSize is {}", header));
  for (SampleBlock& block : volume.blocks) {
    if (header > 0 && own && static_cast<std::uint64_t>(header) < begin_)
      refuse(fmt::format("its field HeaderSize is {}, inside the header of {} bytes", header, begin_));
    if (header > 0) block.begin = static_cast<std::uint64_t>(header);  // from the beginning of the file
    // The samples end with the file.
    if (header == -1 && binary && !packed && bytes >= 0 && bytes < 0x1p62)
      block.begin = std::max(block.begin, before_the_end(block.file, static_cast<std::uint64_t>(bytes)));
  }
  // The size is a hint: the file may hold more, and compressed data say where they end.
  if (const std::string* text = field({"CompressedDataSize"}); text && packed && volume.blocks.size() == 1) {
    const auto size = static_cast<double>(std::filesystem::file_size(volume.blocks[0].file, error));
    const double there = error ? 0 : size - static_cast<double>(volume.blocks[0].begin);
    double claimed = 0;
    if (!parse_number(*text, claimed) || !(claimed >= 0) || claimed > there)
      refuse(fmt::format("it declares {} bytes of compressed samples and has {}; it is damaged or incomplete",
                         shown(*text), std::max(0.0, there)));
    if (claimed > 0 && claimed < there)
      note(context, fmt::format("'{}' says that its compressed samples have {} bytes, and {} are there; all are read",
                                file_.string(), claimed, there));
  }
}

StoredVolume MetaHeader::volume(Context* context) {
  StoredVolume result;
  set_grid(result);
  set_type(result);
  const std::vector<double> slope = numbers({"ElementToIntensityFunctionSlope"}, 1),
                            intercept = numbers({"ElementToIntensityFunctionOffset"}, 1);
  if (!slope.empty() && slope[0] != 0) result.slope = slope[0];
  if (!intercept.empty()) result.intercept = intercept[0];
  if (result.scaled())
    note(context, fmt::format("'{}' has a line of intensities, {:.9g} {} {:.9g} x the stored values "
                              "(ElementToIntensityFunction); thresholds are of these",
                              file_.string(), result.intercept, result.slope < 0 ? "-" : "+", std::abs(result.slope)));
  set_blocks(result, context);
  return result;
}

}  // namespace

StoredVolume meta_header(const std::filesystem::path& file, Context* context) {
  return MetaHeader(file).volume(context);
}

}  // namespace quench::io
