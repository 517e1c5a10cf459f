#include "common/jpeg_decoder.h"

// clang-format off
#include <cstdio>  // Which jpeglib.h needs and leaves out.
#include <jerror.h>
#include <jpeglib.h>
// clang-format on

#include <array>
#include <csetjmp>
#include <string>

#include "common/check.h"
#include "common/format.h"

namespace vantage {
namespace {

// Huffman codes spend a bit at least on each of the two parts of a block of 64 pixels.
constexpr size_t kMostPixelsPerByte = 256;

// libjpeg reports by callbacks that must not return.
struct ErrorHandler {
  jpeg_error_mgr manager;  // First, so that a pointer to it is one to the handler.
  std::jmp_buf escape;
  std::array<char, JMSG_LENGTH_MAX> message;
};

[[noreturn]] void Escape(j_common_ptr decoder) {
  auto* handler = reinterpret_cast<ErrorHandler*>(decoder->err);
  handler->manager.format_message(decoder, handler->message.data());
  std::longjmp(handler->escape, 1);
}

// Warnings (level -1) tell of damage, but for stray bytes that nothing depends on.
void OnMessage(j_common_ptr decoder, int level) {
  if (level < 0 && decoder->err->msg_code != JWRN_EXTRANEOUS_DATA) Escape(decoder);
}

struct Wanted {
  std::span<const uint8_t> jpeg;
  unsigned width;
  unsigned height;
  JpegPixels kind;
  uint8_t* pixels;
};

// No object that needs its destructor lives here: Escape() jumps over this function.
void ReadRows(jpeg_decompress_struct* decoder, uint8_t* pixels) {
  const size_t row_bytes = size_t{decoder->output_width} * decoder->output_components;
  while (decoder->output_scanline < decoder->output_height) {
    JSAMPROW row = pixels + row_bytes * decoder->output_scanline;
    jpeg_read_scanlines(decoder, &row, 1);
  }
}

// What is wrong, or nothing. As ReadRows().
const char* ReadHeader(jpeg_decompress_struct* decoder, const Wanted& wanted) {
  jpeg_mem_src(decoder, wanted.jpeg.data(), wanted.jpeg.size());
  jpeg_read_header(decoder, TRUE);
  if (decoder->image_width != wanted.width || decoder->image_height != wanted.height) {
    return "has another size";
  }
  if (decoder->progressive_mode != 0 || jpeg_has_multiple_scans(decoder) != 0) {
    return "has several scans";
  }
  decoder->out_color_space = wanted.kind == JpegPixels::kGray ? JCS_GRAYSCALE : JCS_RGB;
  return nullptr;
}

// What is wrong, or nothing.
std::string Decode(const Wanted& wanted) {
  ErrorHandler handler{};
  jpeg_decompress_struct decoder{};
  decoder.err = jpeg_std_error(&handler.manager);
  handler.manager.error_exit = Escape;
  handler.manager.emit_message = OnMessage;
  if (setjmp(handler.escape) != 0) {
    jpeg_destroy_decompress(&decoder);
    return handler.message.data();
  }
  jpeg_create_decompress(&decoder);
  const char* fault = ReadHeader(&decoder, wanted);
  if (fault == nullptr) {
    jpeg_start_decompress(&decoder);
    ReadRows(&decoder, wanted.pixels);
    jpeg_finish_decompress(&decoder);
  }
  jpeg_destroy_decompress(&decoder);
  return fault == nullptr ? "" : fault;
}

}  // namespace

Result<void> DecodeJpeg(std::span<const uint8_t> jpeg,
                        int width,
                        int height,
                        JpegPixels kind,
                        std::vector<uint8_t>* pixels) {
  VANTAGE_CHECK(width > 0 && height > 0, Format("%d x %d px", width, height));
  const size_t num_pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  std::string fault = "is too short for its size";
  if (num_pixels <= kMostPixelsPerByte * jpeg.size()) {
    pixels->resize((kind == JpegPixels::kGray ? 1 : 3) * num_pixels);
    fault = Decode({.jpeg = jpeg,
                    .width = static_cast<unsigned>(width),
                    .height = static_cast<unsigned>(height),
                    .kind = kind,
                    .pixels = pixels->data()});
  }
  if (fault.empty()) return {};
  return Error{ErrorCode::kCorrupt,
               Format("JPEG image of %zu bytes: %s, expected a whole baseline image of %d x %d px",
                      jpeg.size(),
                      fault.c_str(),
                      width,
                      height)};
}

}  // namespace vantage
