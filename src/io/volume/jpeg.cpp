// SPDX-License-Identifier: Apache-2.0
// JPEG pictures through libjpeg-turbo. The library leaves an error by longjmp: each call of it stands alone in a
// function whose frames hold nothing that has a destructor, and becomes an exception behind it.
#include <fmt/format.h>

#include "io/volume/pixels.h"
#include "io/volume/volume_formats.h"
#include "quench/error.h"

#ifdef QUENCH_HAS_JPEG
#include <jpeglib.h>  // behind <cstdio>, whose FILE it needs

#include <csetjmp>
#include <cstdio>
#include <memory>

namespace quench::io {
namespace {

struct JpegState {
  jpeg_decompress_struct decoder;
  jpeg_error_mgr errors;
  jpeg_progress_mgr progress;
  std::jmp_buf back;
  char message[JMSG_LENGTH_MAX];
  int most_scans;
};

JpegState& state_of(j_common_ptr decoder) { return *static_cast<JpegState*>(decoder->client_data); }

[[noreturn]] void leave(j_common_ptr decoder) {
  JpegState& state = state_of(decoder);
  decoder->err->format_message(decoder, state.message);
  std::longjmp(state.back, 1);
}

/// A warning is as good as an error: the library goes on with grey where data are damaged or missing.
void on_message(j_common_ptr decoder, int level) {
  if (level < 0) leave(decoder);
}

/// A small file can ask for any number of passes over a large picture.
void on_progress(j_common_ptr decoder) {
  JpegState& state = state_of(decoder);
  if (state.decoder.input_scan_number <= state.most_scans) return;
  std::snprintf(state.message, sizeof state.message, "more than %d scans", state.most_scans);
  std::longjmp(state.back, 1);
}

/// False where the library has given up; then `message` says why. `call` holds references and numbers only.
template <class Call>
bool goes_well(JpegState& state, const Call& call) {
  if (setjmp(state.back) != 0) return false;
  call();
  return true;
}

class JpegFile {
 public:
  explicit JpegFile(const std::filesystem::path& file) : file_(file), state_(std::make_unique<JpegState>()) {
    InputFile in(file);
    bytes_.resize(in.size);
    in.stream.read(reinterpret_cast<char*>(bytes_.data()), static_cast<std::streamsize>(bytes_.size()));
    if (!in.stream || bytes_.size() < 4 || bytes_[0] != 0xFF || bytes_[1] != 0xD8)
      refuse(file_, "JPEG", "it does not begin as one");
    JpegState& s = *state_;
    s.most_scans = 200;
    s.decoder.err = jpeg_std_error(&s.errors);
    s.errors.error_exit = leave;
    s.errors.emit_message = on_message;
    s.decoder.client_data = &s;
    // It checks its version and takes memory; nothing is held when it fails.
    if (!goes_well(s, [&s] { jpeg_create_decompress(&s.decoder); })) give_up();
    s.progress = {};
    s.progress.progress_monitor = on_progress;
    s.decoder.progress = &s.progress;
  }
  JpegFile(const JpegFile&) = delete;
  JpegFile& operator=(const JpegFile&) = delete;
  ~JpegFile() { jpeg_destroy_decompress(&state_->decoder); }

  Pixels read(Context* context) {
    JpegState& s = *state_;
    const unsigned char* data = bytes_.data();
    const auto size = static_cast<unsigned long>(bytes_.size());
    call([&s, data, size] {
      jpeg_mem_src(&s.decoder, data, size);
      jpeg_read_header(&s.decoder, TRUE);
    });
    const std::size_t channels = set_colours();
    const std::uint64_t count = check_size(channels, context);
    std::vector<std::uint8_t> samples(count * channels);
    const std::size_t row = count / s.decoder.image_height * channels;
    unsigned char* out = samples.data();
    call([&s] { jpeg_start_decompress(&s.decoder); });
    while (s.decoder.output_scanline < s.decoder.output_height) {
      checkpoint(context, "read", static_cast<double>(s.decoder.output_scanline) / s.decoder.output_height);
      call([&s, out, row] {
        JSAMPROW to = out + row * s.decoder.output_scanline;
        jpeg_read_scanlines(&s.decoder, &to, 1);
      });
    }
    call([&s] { jpeg_finish_decompress(&s.decoder); });
    pixels_.samples = std::move(samples);
    return std::move(pixels_);
  }

 private:
  [[noreturn]] void give_up() const {
    refuse(file_, "JPEG",
           fmt::format("it is damaged, incomplete or of another kind: libjpeg says '{}'", state_->message));
  }
  template <class Call>
  void call(const Call& work) {
    if (!goes_well(*state_, work)) give_up();
  }

  std::size_t set_colours() {
    jpeg_decompress_struct& d = state_->decoder;
    const bool grey = d.jpeg_color_space == JCS_GRAYSCALE;
    if (!grey && d.jpeg_color_space != JCS_YCbCr && d.jpeg_color_space != JCS_RGB)
      refuse(file_, "JPEG",
             fmt::format("it is a picture of {} colours, as for print; convert it to RGB or grey", d.num_components));
    d.out_color_space = grey ? JCS_GRAYSCALE : JCS_RGB;
    d.dct_method = JDCT_ISLOW;
    pixels_.width = d.image_width;
    pixels_.height = d.image_height;
    pixels_.channels = grey ? 1 : 3;
    pixels_.kind = grey ? "a grey picture" : "an RGB picture";
    return grey ? 1 : 3;
  }

  std::uint64_t check_size(std::size_t channels, const Context* context) {
    const jpeg_decompress_struct& d = state_->decoder;
    // A block of 64 pixels takes a bit at least, in arithmetic coding less.
    const std::uint64_t available = bytes_.size() * (d.arith_code != FALSE ? 1 << 16 : 512);
    const std::uint64_t count = checked_sample_count(file_, {pixels_.width, pixels_.height, 1}, 1, available);
    // Of several scans the library holds the coefficients of all components, of two bytes, padded to blocks.
    const bool scans = jpeg_has_multiple_scans(&state_->decoder) != FALSE;
    const std::uint64_t coefficients = scans ? 2 * static_cast<std::uint64_t>(d.num_components) : 0;
    const std::uint64_t padded = (static_cast<std::uint64_t>(d.image_width) + 31) * (d.image_height + 31);
    check_read_memory(file_, count * channels + padded * coefficients, context);
    return count;
  }

  const std::filesystem::path& file_;
  std::unique_ptr<JpegState> state_;
  std::vector<unsigned char> bytes_;
  Pixels pixels_;
};

}  // namespace

Pixels read_jpeg(const std::filesystem::path& file, Context* context) {
  checkpoint(context, "read", 0);
  Pixels pixels = JpegFile(file).read(context);
  checkpoint(context, "read", 1);
  return pixels;
}

}  // namespace quench::io
#else
namespace quench::io {

Pixels read_jpeg(const std::filesystem::path& file, Context*) {
  throw Error(
      ErrorCode::usage,
      fmt::format("'{}' cannot be read: JPEG needs a Quench built with libjpeg (libjpeg62-turbo-dev); convert it "
                  "to PNG, or rebuild",
                  file.string()));
}

}  // namespace quench::io
#endif
