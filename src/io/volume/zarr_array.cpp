// SPDX-License-Identifier: Apache-2.0
// After the specifications of Zarr 2 and 3 (zarr-specs.readthedocs.io) and N5 (github.com/saalfeldlab/n5).
#include "io/volume/zarr_array.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "base/text.h"
#include "io/common/formats.h"
#include "io/volume/float16.h"
#include "quench/error.h"
#include "shape/sample_type.h"

namespace quench::io {
namespace {

using nlohmann::json;

constexpr bool kLittle = std::endian::native == std::endian::little;

class ZarrMetadata {
 public:
  ZarrMetadata(const std::filesystem::path& file, const ZarrNode& node) : file_(file), node_(node) {}

  ZarrArray array() {
    array_.n5 = node_.format == ZarrFormat::n5;
    if (node_.format == ZarrFormat::zarr2) read_version_2();
    if (node_.format == ZarrFormat::zarr3) read_version_3();
    if (array_.n5) read_n5();
    check_sizes();
    return std::move(array_);
  }

 private:
  [[noreturn]] void refuse(const std::string& why) const { refuse_volume(file_, why); }
  static std::string shown(const std::string& text) { return base::plain(text.substr(0, 60)); }
  static std::string shown(const json& value) {
    return shown(value.dump(-1, ' ', true, json::error_handler_t::replace));
  }

  const json& required(const json& object, const char* name) const {
    const json* value = json_member(object, name);
    if (!value) refuse(fmt::format("its metadata have no '{}'; they are damaged", name));
    return *value;
  }

  /// Lengths along the axes, slowest axis first.
  std::vector<std::int64_t> lengths(const json& object, const char* name) const {
    constexpr std::size_t kMost = 32;
    const json& list = required(object, name);
    if (!list.is_array() || list.size() > kMost)
      refuse(fmt::format("'{}' in its metadata is not a list of up to {} lengths", name, kMost));
    std::vector<std::int64_t> result;
    for (const json& value : list) {
      if (!value.is_number_integer() || value.get<std::int64_t>() < 1)
        refuse(fmt::format("'{}' in its metadata is {}, and lengths are whole numbers above 0", name, shown(list)));
      result.push_back(value.get<std::int64_t>());
    }
    if (array_.n5) std::reverse(result.begin(), result.end());
    return result;
  }

  void set_type(std::string_view kind, std::size_t bytes, const std::string& name) {
    constexpr std::array kUnsigned{SampleType::uint8, SampleType::uint16, SampleType::uint32, SampleType::uint64};
    constexpr std::array kSigned{SampleType::int8, SampleType::int16, SampleType::int32, SampleType::int64};
    const bool power = std::has_single_bit(bytes) && bytes <= 8;
    const auto size = power ? static_cast<std::size_t>(std::countr_zero(bytes)) : 0;
    if (kind == "bool" && bytes == 1)
      array_.type.type = SampleType::uint8;
    else if (kind == "uint" && power)
      array_.type.type = kUnsigned[size];
    else if (kind == "int" && power)
      array_.type.type = kSigned[size];
    else if (kind == "float" && power && bytes >= 2)
      array_.type = {bytes == 8 ? SampleType::float64 : SampleType::float32, bytes == 2};
    else
      refuse(
          fmt::format("its samples are of type {}, and Quench reads whole numbers of 8 to 64 bits and floating-point "
                      "numbers; save it as one of these",
                      name));
  }

  /// "uint16": of version 3 and N5.
  void read_type(const json& value) {
    const std::string name = json_text(&value);
    const std::size_t digits = std::min(name.find_first_of("0123456789"), name.size());
    std::size_t bits = name == "bool" ? 8 : 0;
    std::from_chars(name.data() + digits, name.data() + name.size(), bits);
    set_type(name.substr(0, digits), bits % 8 == 0 ? bits / 8 : 0, shown(value));
  }

  /// "<u2": of version 2.
  void read_dtype(const json& value) {
    const std::string text = json_text(&value);
    std::size_t bytes = 0;
    if (text.size() > 2) std::from_chars(text.data() + 2, text.data() + text.size(), bytes);
    const char kind = text.size() > 2 ? text[1] : ' ';
    set_type(kind == 'b'   ? "bool"
             : kind == 'u' ? "uint"
             : kind == 'i' ? "int"
             : kind == 'f' ? "float"
                           : "",
             bytes, shown(value));
    if (text[0] != '<' && text[0] != '>' && (text[0] != '|' || bytes > 1))
      refuse(fmt::format("its type {} has no byte order", shown(value)));
    array_.swapped = bytes > 1 && (text[0] == '<') != kLittle;
  }

  void read_fill(const json* value) {
    if (!value || value->is_null()) return;
    bool good = false;
    if (array_.type.half || array_.type.type == SampleType::float32)
      good = set_real_fill<float, std::uint32_t>(*value);
    else if (array_.type.type == SampleType::float64)
      good = set_real_fill<double, std::uint64_t>(*value);
    else
      good = set_whole_fill(*value);
    if (!good) refuse(fmt::format("its fill value {} is not a number of its sample type", shown(*value)));
  }

  template <class T, class Bits>
  bool set_real_fill(const json& value) {
    double number = 0;
    const std::string text = json_text(&value);
    if (value.is_number())
      number = value.get<double>();
    else if (text == "NaN")
      number = std::numeric_limits<double>::quiet_NaN();
    else if (text == "Infinity" || text == "-Infinity")
      number = (text[0] == '-' ? -1 : 1) * std::numeric_limits<double>::infinity();
    else
      return set_fill_of_bits<T, Bits>(text);
    constexpr double kRounding = 1 + 1e-7;  // of the largest number, in decimals
    if (std::isfinite(number) && std::abs(number) / kRounding > double{std::numeric_limits<T>::max()}) return false;
    if constexpr (std::is_same_v<T, float>)
      put_fill(array_.type.half        ? nearest_half(number)
               : std::isfinite(number) ? to_float(number)
                                       : static_cast<T>(number));
    else
      put_fill(number);
    return true;
  }

  /// "0x7fc00000": the bits of a sample.
  template <class T, class Bits>
  bool set_fill_of_bits(const std::string& text) {
    Bits bits = 0;
    const std::size_t digits = 2 * array_.type.size();
    if (!text.starts_with("0x") || text.size() != 2 + digits) return false;
    const auto [end, error] = std::from_chars(text.data() + 2, text.data() + text.size(), bits, 16);
    if (error != std::errc() || end != text.data() + text.size()) return false;
    put_fill(array_.type.half ? static_cast<T>(from_half(static_cast<std::uint16_t>(bits))) : std::bit_cast<T>(bits));
    return true;
  }

  static float nearest_half(double number) {
    constexpr std::uint32_t kInfinity = 0x7C00;
    if (!std::isfinite(number)) return static_cast<float>(number);
    float nearest = 0;
    for (std::uint32_t bits = 0; bits < kInfinity; ++bits) {
      const float half = std::copysign(from_half(static_cast<std::uint16_t>(bits)), static_cast<float>(number));
      if (std::abs(static_cast<double>(half) - number) < std::abs(static_cast<double>(nearest) - number))
        nearest = half;
    }
    return nearest;
  }

  bool set_whole_fill(const json& value) {
    return shape::with_sample_type(array_.type.type, [&]<class T>(T) {
      const auto put = [&](auto number) {
        if constexpr (std::is_integral_v<T>) {
          if (!std::in_range<T>(number)) return false;
          put_fill(static_cast<T>(number));
        }
        return true;
      };
      if (value.is_boolean()) return put(value.get<bool>() ? 1 : 0);
      if (value.is_number_unsigned()) return put(value.get<std::uint64_t>());
      if (value.is_number_integer()) return put(value.get<std::int64_t>());
      const double real = value.is_number_float() ? value.get<double>() : 0.5;  // some write 0.0
      return std::abs(real) < 0x1p53 && std::floor(real) == real && put(static_cast<std::int64_t>(real));
    });
  }

  template <class T>
  void put_fill(T value) {
    std::memcpy(array_.fill.data(), &value, sizeof value);
  }

  void set_order(bool first_is_fastest) {
    array_.order.resize(array_.axes());
    std::iota(array_.order.begin(), array_.order.end(), std::size_t{0});
    if (first_is_fastest) std::reverse(array_.order.begin(), array_.order.end());
  }

  void add_codec(const std::string& name) { array_.codecs.push_back(chunk_codec(file_, name)); }

  /// Names from a list of texts, of which null is one without a name.
  void read_names(const json* list) {
    if (!list || !list->is_array() || list->size() != array_.axes()) return;
    for (const json& name : *list) array_.names.push_back(json_text(&name));
  }

  void read_version_2();
  void read_version_3();
  void read_keys(const json& meta);
  void read_codecs(const json& codecs, std::size_t depth);
  void read_transpose(const json& configuration);
  void read_bytes(const json& configuration);
  void read_sharding(const json& configuration);
  void read_n5();
  void check_sizes() const;

  std::filesystem::path file_;
  const ZarrNode& node_;
  ZarrArray array_;
};

void ZarrMetadata::read_version_2() {
  const json& meta = node_.meta;
  array_.shape = lengths(meta, "shape");
  array_.chunk = lengths(meta, "chunks");
  read_dtype(required(meta, "dtype"));
  read_fill(json_member(meta, "fill_value"));
  const std::string order = json_text(json_member(meta, "order"));
  if (order != "C" && order != "F") refuse("'order' in its metadata is neither \"C\" nor \"F\"");
  set_order(order == "F");
  if (const json* filters = json_member(meta, "filters"); filters && filters->is_array() && !filters->empty())
    refuse(fmt::format("its chunks went through the filter {}, which Quench does not undo; save it without filters",
                       shown(json_member(filters->front(), "id") ? *json_member(filters->front(), "id") : json())));
  if (const json* packed = json_member(meta, "compressor"); packed && !packed->is_null())
    add_codec(json_text(json_member(*packed, "id")));
  const std::string separator = json_text(json_member(meta, "dimension_separator"));
  if (separator == "/") array_.separator = '/';
  read_names(json_member(node_.attributes, "_ARRAY_DIMENSIONS"));
}

void ZarrMetadata::read_version_3() {
  const json& meta = node_.meta;
  array_.shape = lengths(meta, "shape");
  const json& grid = required(meta, "chunk_grid");
  if (json_text(json_member(grid, "name")) != "regular") refuse("its chunks are not on a regular grid");
  array_.chunk = lengths(required(grid, "configuration"), "chunk_shape");
  read_type(required(meta, "data_type"));
  read_fill(&required(meta, "fill_value"));
  read_keys(required(meta, "chunk_key_encoding"));
  set_order(false);
  read_codecs(required(meta, "codecs"), 0);
  read_names(json_member(meta, "dimension_names"));
  if (const json* list = json_member(meta, "storage_transformers"); list && !list->empty())
    refuse("it has storage transformers, which Quench does not know");
}

void ZarrMetadata::read_keys(const json& encoding) {
  const std::string name = json_text(json_member(encoding, "name"));
  if (name != "default" && name != "v2")
    refuse(fmt::format("its chunks are named by the rule '{}', which Quench does not know", shown(name)));
  const json* configuration = json_member(encoding, "configuration");
  const std::string separator = configuration ? json_text(json_member(*configuration, "separator")) : "";
  array_.separator = separator.empty() ? (name == "v2" ? '.' : '/') : separator[0];
  if (separator.size() > 1 || (array_.separator != '.' && array_.separator != '/'))
    refuse("the names of its chunks are separated by neither '.' nor '/'");
  if (name == "default") array_.prefix = std::string("c") + array_.separator;
}

/// `depth`: 1 inside of a shard.
void ZarrMetadata::read_codecs(const json& codecs, std::size_t depth) {
  if (!codecs.is_array()) refuse("the codecs in its metadata are not a list");
  bool as_bytes = false;
  for (const json& codec : codecs) {
    const std::string name = codec.is_string() ? codec.get<std::string>() : json_text(json_member(codec, "name"));
    const json* found = json_member(codec, "configuration");
    const json configuration = found ? *found : json::object();
    if (!array_.shard.empty() && depth == 0) refuse(fmt::format("its shards are packed by '{}'", shown(name)));
    if (name == "transpose" && !as_bytes) {
      read_transpose(configuration);
    } else if (name == "bytes" && !as_bytes) {
      read_bytes(configuration);
      as_bytes = true;
    } else if (name == "sharding_indexed" && !as_bytes && depth == 0 && &codec == &codecs.front()) {
      read_sharding(configuration);
      as_bytes = true;
    } else if (as_bytes) {
      add_codec(name);
    } else {
      refuse(
          fmt::format("its samples go through the codec '{}' at a place where Quench does not undo it; save it with "
                      "the codecs bytes and gzip, zstd or blosc",
                      shown(name)));
    }
  }
  if (!as_bytes) refuse("its metadata do not say how samples become bytes: the codec 'bytes' is missing");
}

void ZarrMetadata::read_transpose(const json& configuration) {
  const json& list = required(configuration, "order");
  std::vector<std::size_t> order;
  if (list == "F") {
    for (std::size_t a = array_.axes(); a-- > 0;) order.push_back(a);
  } else if (list.is_array()) {
    for (const json& axis : list)
      if (axis.is_number_unsigned()) order.push_back(axis.get<std::size_t>());
  }
  std::vector<std::size_t> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::size_t> axes(array_.axes());
  std::iota(axes.begin(), axes.end(), std::size_t{0});
  if (list != "C" && sorted != axes) refuse("its codec 'transpose' does not name every axis once");
  if (list == "C") return;
  std::vector<std::size_t> transposed;
  for (const std::size_t axis : order) transposed.push_back(array_.order[axis]);
  array_.order = transposed;
}

void ZarrMetadata::read_bytes(const json& configuration) {
  const std::string endian = json_text(json_member(configuration, "endian"));
  const bool matters = array_.type.size() > 1;
  if (matters && endian != "little" && endian != "big")
    refuse("the codec 'bytes' in its metadata has no byte order ('endian')");
  array_.swapped = matters && (endian == "little") != kLittle;
}

void ZarrMetadata::read_sharding(const json& configuration) {
  array_.shard = array_.chunk;
  array_.chunk = lengths(configuration, "chunk_shape");
  bool divided = array_.chunk.size() == array_.axes() && array_.shard.size() == array_.axes();
  for (std::size_t a = 0; divided && a < array_.axes(); ++a) divided = array_.shard[a] % array_.chunk[a] == 0;
  if (!divided) refuse("its shards are not divided into whole chunks");
  std::vector<std::string> names;
  for (const json& codec : required(configuration, "index_codecs")) {
    names.push_back(codec.is_string() ? codec.get<std::string>() : json_text(json_member(codec, "name")));
    if (names.back() == "bytes" && codec.dump().find("big") != std::string::npos) names.back() = "big";
  }
  array_.index_checked = names == std::vector<std::string>{"bytes", "crc32c"};
  if (!array_.index_checked && names != std::vector<std::string>{"bytes"})
    refuse("the index of its shards is packed in a way that Quench does not know");
  array_.index_first = json_text(json_member(configuration, "index_location")) == "start";
  read_codecs(required(configuration, "codecs"), 1);
}

void ZarrMetadata::read_n5() {
  const json& meta = node_.meta;
  array_.shape = lengths(meta, "dimensions");
  array_.chunk = lengths(meta, "blockSize");
  read_type(required(meta, "dataType"));
  array_.swapped = array_.type.size() > 1 && kLittle;
  array_.separator = '/';
  set_order(false);
  const json* compression = json_member(meta, "compression");
  const std::string name = compression ? json_text(json_member(*compression, "type"))
                                       : json_text(json_member(meta, "compressionType"));  // before version 2
  if (name != "raw") add_codec(name == "zstandard" ? "zstd" : name);
}

void ZarrMetadata::check_sizes() const {
  constexpr double kLargestChunk = std::numeric_limits<std::int32_t>::max();
  if (array_.chunk.size() != array_.axes())
    refuse(fmt::format("its chunks have {} axes and the array {}", array_.chunk.size(), array_.axes()));
  double bytes = static_cast<double>(array_.type.size());
  for (const std::int64_t side : array_.chunk) bytes *= static_cast<double>(side);
  if (bytes > kLargestChunk) refuse("its metadata claim chunks of 2 GiB or more; save it with smaller ones");
  if (std::ranges::count_if(array_.codecs, [](ChunkCodec c) { return c != ChunkCodec::crc32c; }) > 1)
    refuse("its chunks are packed twice; save it with one of gzip, zstd and blosc");
}

}  // namespace

ZarrArray zarr_array(const std::filesystem::path& file, const ZarrNode& node) {
  return ZarrMetadata(file, node).array();
}

}  // namespace quench::io
