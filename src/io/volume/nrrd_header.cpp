// SPDX-License-Identifier: Apache-2.0
// NRRD headers, after the definition of the format at teem.sourceforge.net/nrrd/format.html (NRRD0005).
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>

#include "base/text.h"
#include "io/common/words.h"
#include "io/volume/data_files.h"
#include "io/volume/stored_volume.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"

namespace quench::io {
namespace {

constexpr std::size_t kMostAxes = 16;  // of the format

struct Axis {
  std::int64_t size = 0;
  double spacing = std::nan(""), low = std::nan(""), high = std::nan("");
  std::optional<std::vector<double>> direction;  ///< as long as the space has dimensions; none: not an axis of space
  std::string kind, unit;
  bool node = false;  ///< samples at the ends of the axis' range, not in the middle of cells
};

/// A header as it is in the file.
class NrrdHeader {
 public:
  explicit NrrdHeader(const std::filesystem::path& file) : file_(file), input_(file) {
    std::string line;
    if (!next_header_line(input_.stream, file_, line) || !line.starts_with("NRRD000") || line.size() < 8 ||
        line[7] < '1' || line[7] > '5')
      refuse("it does not begin with NRRD0001 to NRRD0005");
    while (next_line(line)) parse(line);
    check();
  }

  StoredVolume volume();

 private:
  [[noreturn]] void refuse(const std::string& why) const { refuse_volume(file_, why); }

  /// False at the empty line that ends the header and at the end of the file.
  bool next_line(std::string& line) {
    if (!next_header_line(input_.stream, file_, line)) {
      at_end_ = true;
      return false;
    }
    return !line.empty();
  }

  void parse(const std::string& line) {
    if (line[0] == '#') return;
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos || colon == 0)
      refuse(fmt::format("a line of its header has no field: '{}'", shown(line)));
    if (line.substr(colon, 2) == ":=") return read_key(line.substr(0, colon), line.substr(colon + 2));
    std::string name = lower(line.substr(0, colon));
    std::erase(name, ' ');
    const std::string value(trimmed(std::string_view(line).substr(colon + 1)));
    if (!fields_.emplace(name, value).second) refuse(fmt::format("its header has the field '{}' twice", shown(name)));
    known(name, line);
    if (name == "datafile" && lower(value).starts_with("list")) read_list();
  }

  // Keys are those of the programs that write them; io::write_volume() says of planes which way y grows.
  void read_key(const std::string& name, const std::string& value) {
    if (name == "y_axis" && (value == "down" || value == "up")) y_recorded_ = value == "down";
  }

  // An unknown field may change what the samples mean; a misspelt one would leave out what it says.
  void known(const std::string& name, const std::string& line) const {
    for (const char* field :
         {"content",    "number",         "type",       "blocksize",   "dimension",       "sizes",
          "spacings",   "thicknesses",    "axismins",   "axismaxs",    "centers",         "centerings",
          "labels",     "units",          "kinds",      "endian",      "encoding",        "min",
          "max",        "oldmin",         "oldmax",     "lineskip",    "byteskip",        "datafile",
          "space",      "spacedimension", "spaceunits", "spaceorigin", "spacedirections", "measurementframe",
          "sampleunits"})
      if (name == field) return;
    refuse(fmt::format("its header has the unknown field '{}'", shown(line.substr(0, line.find(':')))));
  }

  // The names of the data files are the rest of the header, one per line.
  void read_list() {
    std::string line;
    while (next_header_line(input_.stream, file_, line)) {
      const std::string_view name = trimmed(line);
      if (!name.empty()) list_.emplace_back(name);
      if (list_.size() > kMostDataFiles) refuse("it names more than 100,000 data files");
    }
    at_end_ = true;
  }

  static std::string shown(std::string_view text) { return base::plain(std::string(text.substr(0, 60))); }

  const std::string* field(const char* name) const {
    const auto found = fields_.find(name);
    return found == fields_.end() ? nullptr : &found->second;
  }
  const std::string& required(const char* name) const {
    const std::string* value = field(name);
    if (!value) refuse(fmt::format("its header has no field '{}'", name));
    return *value;
  }
  double number(std::string_view word, const char* what) const {
    double value = 0;
    if (!parse_number(word, value)) refuse(fmt::format("'{}' in its field '{}' is not a number", shown(word), what));
    return value;
  }
  std::int64_t integer(std::string_view word, const char* what) const {
    std::int64_t value = 0;
    if (!parse_integer(word, value)) refuse(fmt::format("'{}' in its field '{}' is not an integer", shown(word), what));
    return value;
  }

  void check();
  void read_axes();
  void read_directions();
  std::vector<double> vector(std::string_view text, const char* what) const;
  std::vector<std::string> quoted(const std::string& text) const;
  template <class Set>
  void each_axis(const char* name, const Set& set);
  void keep_three_axes();
  void set_geometry(StoredVolume& volume) const;
  Vec3 lps(const std::vector<double>& v) const;
  void set_samples(StoredVolume& volume);

  std::filesystem::path file_;
  InputFile input_;
  bool at_end_ = false;
  std::map<std::string, std::string> fields_;  ///< names in lower case without blanks
  std::vector<std::string> list_;
  std::vector<Axis> axes_;
  std::size_t space_dimension_ = 0;
  Vec3 to_lps_ = Vec3::Ones();  ///< signs from the file's space
  bool anatomical_ = false;
  std::string space_;  ///< name of the space where it is not anatomical
  std::optional<bool> y_recorded_;
};

void NrrdHeader::check() {
  const std::int64_t dimension = integer(required("dimension"), "dimension");
  if (dimension < 1 || dimension > static_cast<std::int64_t>(kMostAxes))
    refuse(fmt::format("it has {} axes; a volume has three", dimension));
  axes_.resize(static_cast<std::size_t>(dimension));
  const auto sizes = words_of(required("sizes"));
  if (sizes.size() != axes_.size()) refuse(fmt::format("it has {} sizes for {} axes", sizes.size(), axes_.size()));
  for (std::size_t a = 0; a < axes_.size(); ++a) axes_[a].size = integer(sizes[a], "sizes");
  read_axes();
  read_directions();
  keep_three_axes();
}

/// Calls `set(axis, word)` for each word of a field that has one per axis.
template <class Set>
void NrrdHeader::each_axis(const char* name, const Set& set) {
  const std::string* text = field(name);
  if (!text) return;
  const auto words = words_of(*text);
  if (words.size() != axes_.size())
    refuse(fmt::format("its field '{}' has {} values for {} axes", name, words.size(), axes_.size()));
  for (std::size_t a = 0; a < words.size(); ++a) set(axes_[a], words[a]);
}

void NrrdHeader::read_axes() {
  each_axis("spacings", [&](Axis& axis, std::string_view word) { axis.spacing = number(word, "spacings"); });
  each_axis("axismins", [&](Axis& axis, std::string_view word) { axis.low = number(word, "axis mins"); });
  each_axis("axismaxs", [&](Axis& axis, std::string_view word) { axis.high = number(word, "axis maxs"); });
  each_axis("kinds", [&](Axis& axis, std::string_view word) { axis.kind = word; });
  for (const char* name : {"centers", "centerings"})
    each_axis(name, [&](Axis& axis, std::string_view word) { axis.node = lower(word) == "node"; });
  if (const std::string* units = field("units"))
    if (const auto texts = quoted(*units); texts.size() == axes_.size())
      for (std::size_t a = 0; a < texts.size(); ++a) axes_[a].unit = texts[a];
}

/// "mm" "mm" "um": the texts between quotation marks.
std::vector<std::string> NrrdHeader::quoted(const std::string& text) const {
  std::vector<std::string> result;
  for (std::size_t at = text.find('"'); at != std::string::npos;) {
    const std::size_t end = text.find('"', at + 1);
    if (end == std::string::npos) break;
    result.push_back(text.substr(at + 1, end - at - 1));
    at = text.find('"', end + 1);
  }
  return result;
}

/// "(1,0.5,-3e2)".
std::vector<double> NrrdHeader::vector(std::string_view text, const char* what) const {
  text = trimmed(text);
  if (text.size() < 2 || text.front() != '(' || text.back() != ')')
    refuse(fmt::format("'{}' in its field '{}' is not a vector", shown(text), what));
  std::vector<double> values;
  text = text.substr(1, text.size() - 2);
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    values.push_back(number(trimmed(text.substr(at, end - at)), what));
    at = end + 1;
  }
  if (values.size() != space_dimension_)
    refuse(fmt::format("'({})' in its field '{}' has {} components for a space of {} dimensions", shown(text), what,
                       values.size(), space_dimension_));
  return values;
}

void NrrdHeader::read_directions() {
  if (const std::string* space = field("space")) {
    std::string name = lower(*space);
    space_dimension_ = 3;
    if (name.ends_with("-time")) {
      space_dimension_ = 4;
      name.resize(name.size() - 5);
    } else if (name.size() == 4 && name.back() == 't') {  // RAST, LAST, LPST
      space_dimension_ = 4;
      name.pop_back();
    }
    // "left-posterior-superior" or "lps": where the axes point to.
    if (std::count(name.begin(), name.end(), '-') == 2 && !name.starts_with("3d-")) {
      const std::size_t second = name.find('-') + 1, third = name.find('-', second) + 1;
      name = {name[0], name[second], name[third]};
    }
    constexpr std::array<std::string_view, 3> kPositive{"lr", "pa", "si"};
    anatomical_ = name.size() == 3;
    for (std::size_t a = 0; a < 3 && anatomical_; ++a) {
      anatomical_ = kPositive[a].find(name[a]) != std::string_view::npos;
      to_lps_[static_cast<int>(a)] = name[a] == kPositive[a][1] ? -1 : 1;
    }
    // Spacings alone do not say how the axes lie in the space.
    if (anatomical_ && !field("spacedirections")) {
      anatomical_ = false;
      to_lps_.setOnes();
    } else if (!anatomical_) {
      to_lps_.setOnes();
      space_ = name.starts_with("3d") ? "3D" + name.substr(2) : name;  // as the format writes it
      if (name != "scanner-xyz" && name != "3d-right-handed" && name != "3d-left-handed")
        refuse(fmt::format("its field 'space' is '{}', which is not a space of the format", shown(*space)));
    }
  }
  if (const std::string* dimension = field("spacedimension")) {
    const std::int64_t value = integer(*dimension, "space dimension");
    if (value < 1 || value > 8) refuse(fmt::format("its space has {} dimensions; a volume needs three", value));
    if (space_dimension_ != 0 && static_cast<std::int64_t>(space_dimension_) != value)
      refuse("its fields 'space' and 'space dimension' contradict each other");
    space_dimension_ = static_cast<std::size_t>(value);
  }
  const std::string* directions = field("spacedirections");
  if (!directions) return;
  if (space_dimension_ == 0) refuse("it has 'space directions' and neither 'space' nor 'space dimension'");
  // Vectors may contain blanks; they end with a parenthesis.
  std::string_view rest = trimmed(*directions);
  for (Axis& axis : axes_) {
    const bool is_vector = rest.starts_with('(');
    const std::size_t end = is_vector ? rest.find(')') + 1 : std::min(rest.find_first_of(" \t("), rest.size());
    if (rest.empty() || (is_vector && end == 0))
      refuse("its field 'space directions' has fewer vectors than it has axes");
    if (is_vector) {
      axis.direction = vector(rest.substr(0, end), "space directions");
    } else if (rest.substr(0, end) != "none") {
      refuse(fmt::format("'{}' in its field 'space directions' is neither a vector nor 'none'",
                         shown(rest.substr(0, end))));
    }
    rest = trimmed(rest.substr(end));
  }
  if (!rest.empty()) refuse("its field 'space directions' has more vectors than it has axes");
}

/// Axes of one sample that are not of space, or more than three, are dropped.
void NrrdHeader::keep_three_axes() {
  const bool with_directions = field("spacedirections") != nullptr;
  const auto is_space = [&](const Axis& axis) {
    if (with_directions) return axis.direction.has_value();
    const std::string kind = lower(axis.kind);
    return kind.empty() || kind == "???" || kind == "none" || kind == "domain" || kind == "space";
  };
  for (std::size_t a = axes_.size(); a-- > 0;) {
    if (is_space(axes_[a])) continue;
    if (axes_[a].size != 1) {
      const std::string kind = axes_[a].kind.empty() ? std::string() : fmt::format(" ({})", shown(axes_[a].kind));
      refuse(fmt::format("it has {} values{} per voxel where one is needed; convert it to grey values or labels",
                         axes_[a].size, kind));
    }
    axes_.erase(axes_.begin() + static_cast<std::ptrdiff_t>(a));
  }
  for (std::size_t a = axes_.size(); a-- > 0 && axes_.size() > 3;)
    if (axes_[a].size == 1) axes_.erase(axes_.begin() + static_cast<std::ptrdiff_t>(a));
  if (axes_.size() > 3 || axes_.empty())
    refuse(fmt::format("it is an image of {} dimensions where three are needed; save the volume you mean on its own",
                       axes_.size()));
}

Vec3 NrrdHeader::lps(const std::vector<double>& v) const {
  Vec3 result = Vec3::Zero();
  for (std::size_t i = 0; i < std::min<std::size_t>(3, v.size()); ++i) result[static_cast<int>(i)] = v[i];
  return result.cwiseProduct(to_lps_);
}

void NrrdHeader::set_geometry(StoredVolume& volume) const {
  Grid& grid = volume.grid;
  grid.dims.fill(1);
  for (std::size_t a = 0; a < axes_.size(); ++a) grid.dims[a] = axes_[a].size;
  if (axes_.size() == 2) grid.dimension = 2;
  const std::string* origin = field("spaceorigin");
  if (origin && space_dimension_ == 0) refuse("it has a 'space origin' and neither 'space' nor 'space dimension'");
  if (field("spacedirections")) {
    Mat3 steps = Mat3::Zero();
    for (std::size_t a = 0; a < axes_.size(); ++a) steps.col(static_cast<int>(a)) = lps(*axes_[a].direction);
    if (axes_.size() == 1) steps.col(1) = steps.col(0).stableNormalized().unitOrthogonal();
    if (axes_.size() <= 2) steps.col(2) = steps.col(0).stableNormalized().cross(steps.col(1).stableNormalized());
    // An unknown step is not a number; its length is taken as 1.
    bool unknown = false;
    for (int a = 0; a < 3; ++a)
      if (steps.col(a).array().isNaN().all()) {
        steps.col(a) = Vec3::Unit(a);
        unknown = true;
      }
    set_steps(file_, steps, "'space directions'", grid);
    if (!unknown) volume.spacing_source = "the space directions of the header";
    const std::string* units = field("spaceunits");
    const auto texts = units ? quoted(*units) : std::vector<std::string>();
    const std::size_t needed = axes_.size() == 2 && space_dimension_ == 2 ? 2 : 3;
    if (texts.size() >= needed && std::adjacent_find(texts.begin(), texts.end(), std::not_equal_to<>()) == texts.end())
      volume.coordinates.units = base::plain(texts[0]);
  } else {
    for (std::size_t a = 0; a < axes_.size(); ++a) {
      const Axis& axis = axes_[a];
      const auto i = static_cast<int>(a);
      double step = axis.spacing;
      const double intervals = static_cast<double>(axis.size) - (axis.node ? 1 : 0);
      if (std::isnan(step) && std::isfinite(axis.low) && std::isfinite(axis.high) && intervals > 0)
        step = (axis.high - axis.low) / intervals;
      if (std::isnan(step)) step = 1;
      if (step < 0) grid.direction(i, i) = -1;
      grid.spacing[i] = std::abs(step);
      if (!std::isnan(axis.spacing)) volume.spacing_source = "the spacings of the header";
      if (std::isfinite(axis.low)) grid.origin[i] = axis.low + (axis.node ? 0 : step / 2);
    }
    if (!axes_[0].unit.empty() &&
        std::all_of(axes_.begin(), axes_.end(), [&](const Axis& axis) { return axis.unit == axes_[0].unit; }))
      volume.coordinates.units = base::plain(axes_[0].unit);
  }
  if (origin) grid.origin = lps(vector(*origin, "space origin"));
  if (!grid.origin.allFinite()) refuse("its origin is not a point; correct the 'space origin' in its header");
  volume.coordinates.space = anatomical_ ? "LPS" : space_;
  volume.coordinates.y_recorded = y_recorded_;
}

std::optional<SampleType> nrrd_type(const std::string& name) {
  const auto among = [&](std::initializer_list<const char*> names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  if (among({"signed char", "int8", "int8_t"})) return SampleType::int8;
  if (among({"uchar", "unsigned char", "uint8", "uint8_t"})) return SampleType::uint8;
  if (among({"short", "short int", "signed short", "signed short int", "int16", "int16_t"})) return SampleType::int16;
  if (among({"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"})) return SampleType::uint16;
  if (among({"int", "signed int", "int32", "int32_t"})) return SampleType::int32;
  if (among({"uint", "unsigned int", "uint32", "uint32_t"})) return SampleType::uint32;
  if (among({"longlong", "long long", "long long int", "signed long long", "signed long long int", "int64", "int64_t"}))
    return SampleType::int64;
  if (among({"ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"}))
    return SampleType::uint64;
  if (name == "float") return SampleType::float32;
  if (name == "double") return SampleType::float64;
  return {};
}

void NrrdHeader::set_samples(StoredVolume& volume) {
  const auto type = nrrd_type(lower(required("type")));
  if (!type)
    refuse(fmt::format("its samples are of type '{}'; convert them to integers, float or double",
                       shown(required("type"))));
  volume.type.type = *type;
  const std::string encoding = lower(required("encoding"));
  if (encoding == "raw")
    volume.encoding = Encoding::raw;
  else if (encoding == "gzip" || encoding == "gz")
    volume.encoding = Encoding::deflate;
  else if (encoding == "txt" || encoding == "text" || encoding == "ascii")
    volume.encoding = Encoding::text;
  else if (encoding == "hex")
    volume.encoding = Encoding::hex;
  else
    refuse(fmt::format("its encoding is '{}'; save it with the encoding raw or gzip", shown(encoding)));
  if (volume.type.size() > 1 && volume.encoding != Encoding::text) {
    const std::string endian = lower(required("endian"));
    if (endian != "little" && endian != "big") refuse(fmt::format("its byte order is '{}'", shown(endian)));
    volume.swapped = (endian == "little") != (std::endian::native == std::endian::little);
  }
  const auto skip = [&](const char* name, std::int64_t least) {
    const std::string* text = field(name);
    const std::int64_t value = text ? integer(*text, name) : 0;
    if (value < least) refuse(fmt::format("its field '{}' is {}", name, value));
    return value;
  };
  const std::int64_t lines = skip("lineskip", 0);
  const std::int64_t bytes =
      skip("byteskip", volume.encoding == Encoding::raw ? std::numeric_limits<std::int64_t>::min() / 2 : 0);
  if (const std::string* data = field("datafile")) {
    volume.blocks = named_data_files(file_, *data, list_, axes_.size(), "data file");
  } else {
    if (at_end_) refuse("its header does not end with an empty line; it is damaged or incomplete");
    volume.blocks.push_back(
        {file_, static_cast<std::uint64_t>(static_cast<std::streamoff>(input_.stream.tellg())), 0, {}});
  }
  std::uint64_t samples = volume.type.size();
  for (const std::int64_t side : volume.grid.dims) {
    if (side < 1 || samples > (std::uint64_t{1} << 62) / static_cast<std::uint64_t>(side))
      return;  // open_stored() says so
    samples *= static_cast<std::uint64_t>(side);
  }
  for (SampleBlock& block : volume.blocks) {
    if (lines > 0) block.begin = after_lines(block.file, block.begin, lines);
    if (volume.encoding == Encoding::deflate)
      block.skip = static_cast<std::uint64_t>(bytes);
    else if (bytes >= 0)
      block.begin += static_cast<std::uint64_t>(bytes);
    else  // from the end: -1 for samples that end with the file
      block.begin = std::max(block.begin, before_the_end(block.file, samples / volume.blocks.size() +
                                                                         static_cast<std::uint64_t>(-(bytes + 1))));
  }
}

StoredVolume NrrdHeader::volume() {
  StoredVolume result;
  set_geometry(result);
  set_samples(result);
  return result;
}

}  // namespace

StoredVolume nrrd_header(const std::filesystem::path& file) { return NrrdHeader(file).volume(); }

}  // namespace quench::io
