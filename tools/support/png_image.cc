#include "tools/support/png_image.h"

#include <png.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstring>
#include <string>
#include <string_view>

#include "common/format.h"
#include "perception/model/file_bytes.h"

namespace vantage {
namespace {

constexpr int kLargestSide = 16384;           // px
constexpr size_t kLargestFile = 256U << 20U;  // bytes

// libpng leaves a function in trouble by longjmp. So every function that calls setjmp holds nothing
// that has a destructor: objects live in its caller and are reached through this.
struct PngContext {
  png_structp png = nullptr;
  png_infop info = nullptr;
  const uint8_t* input = nullptr;
  size_t input_left = 0;
  std::vector<uint8_t>* output = nullptr;
  std::array<char, 128> message{};
};

void OnError(png_structp png, png_const_charp message) {
  auto* context = static_cast<PngContext*>(png_get_error_ptr(png));
  std::strncpy(context->message.data(), message, context->message.size() - 1);
  png_longjmp(png, 1);
}

void OnWarning(png_structp /*png*/, png_const_charp /*message*/) {}

void OnRead(png_structp png, png_bytep data, size_t size) {
  auto* context = static_cast<PngContext*>(png_get_io_ptr(png));
  if (size > context->input_left) png_error(png, "the file ends too early");
  std::memcpy(data, context->input, size);
  context->input += size;
  context->input_left -= size;
}

void OnWrite(png_structp png, png_bytep data, size_t size) {
  auto* context = static_cast<PngContext*>(png_get_io_ptr(png));
  context->output->insert(context->output->end(), data, data + size);
}

void OnFlush(png_structp /*png*/) {}

// What the pixels of a picture look like to libpng.
struct Layout {
  int width;
  int height;
  int bit_depth;
  int color_type;
};

// Returns false after an error, which context->message tells.
bool WriteRows(PngContext* context, const Layout& layout, uint8_t* const* rows) {
  if (setjmp(png_jmpbuf(context->png)) != 0) return false;
  png_set_write_fn(context->png, context, OnWrite, OnFlush);
  png_set_compression_level(context->png, 6);
  png_set_IHDR(context->png,
               context->info,
               static_cast<png_uint_32>(layout.width),
               static_cast<png_uint_32>(layout.height),
               layout.bit_depth,
               layout.color_type,
               PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(context->png, context->info);
  if (layout.bit_depth == 16) png_set_swap(context->png);  // PNG is big-endian.
  for (int row = 0; row < layout.height; ++row) png_write_row(context->png, rows[row]);
  png_write_end(context->png, context->info);
  return true;
}

Result<std::vector<uint8_t>> Encode(const Layout& layout, const uint8_t* pixels, size_t row_bytes) {
  std::vector<uint8_t> bytes;
  // libpng does not change what it writes, but its interface is not const.
  std::vector<uint8_t> copy(pixels, pixels + row_bytes * static_cast<size_t>(layout.height));
  std::vector<uint8_t*> rows;
  for (int row = 0; row < layout.height; ++row) {
    rows.push_back(copy.data() + row_bytes * static_cast<size_t>(row));
  }
  PngContext context;
  context.output = &bytes;
  context.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &context, OnError, OnWarning);
  if (context.png != nullptr) context.info = png_create_info_struct(context.png);
  const bool written = context.info != nullptr && WriteRows(&context, layout, rows.data());
  png_destroy_write_struct(&context.png, &context.info);
  if (!written) {
    return Error{ErrorCode::kIo, Format("PNG can't be encoded: %s", context.message.data())};
  }
  return bytes;
}

Result<void> CheckSize(int width, int height, size_t values, size_t values_per_pixel) {
  if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("picture of %d x %d px, expected 1 to %d each", width, height, kLargestSide)};
  }
  const size_t expected =
      static_cast<size_t>(width) * static_cast<size_t>(height) * values_per_pixel;
  if (values != expected) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format(
            "picture of %d x %d px has %zu values, expected %zu", width, height, values, expected)};
  }
  return {};
}

template <class Image>
Result<void> Write(const std::filesystem::path& file, const Image& image) {
  const Result<std::vector<uint8_t>> bytes = EncodePng(image);
  if (!bytes) return Error{bytes.error().code, file.string() + ": " + bytes.error().message};
  const std::filesystem::path temporary = file.string() + Format(".%d.part", ::getpid());
  Result<void> written = WriteFileBytes(
      temporary, std::string_view(reinterpret_cast<const char*>(bytes->data()), bytes->size()));
  if (!written) return written;
  std::error_code error;
  std::filesystem::rename(temporary, file, error);
  if (error) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    return Error{ErrorCode::kIo,
                 Format("%s can't be written: %s", file.c_str(), error.message().c_str())};
  }
  return {};
}

bool ReadHeader(PngContext* context, Layout* layout) {
  if (setjmp(png_jmpbuf(context->png)) != 0) return false;
  png_set_read_fn(context->png, context, OnRead);
  png_set_user_limits(context->png, kLargestSide, kLargestSide);
  png_read_info(context->png, context->info);
  layout->width = static_cast<int>(png_get_image_width(context->png, context->info));
  layout->height = static_cast<int>(png_get_image_height(context->png, context->info));
  layout->bit_depth = png_get_bit_depth(context->png, context->info);
  layout->color_type = png_get_color_type(context->png, context->info);
  return true;
}

bool ReadRows(PngContext* context, uint8_t** rows) {
  if (setjmp(png_jmpbuf(context->png)) != 0) return false;
  png_set_interlace_handling(context->png);
  png_set_swap(context->png);
  png_read_update_info(context->png, context->info);
  png_read_image(context->png, rows);
  png_read_end(context->png, nullptr);
  return true;
}

// Fills `image` by a context that is set up; the caller destroys the context whatever happens.
template <class Image>
Result<void> Read(const std::filesystem::path& file, PngContext* context, Image* image) {
  constexpr size_t kBytes = sizeof(typename decltype(image->gray)::value_type);
  const auto damaged = [&file, context] {
    return Error{ErrorCode::kCorrupt,
                 Format("%s is no sound PNG: %s", file.c_str(), context->message.data())};
  };
  Layout layout{};
  if (context->info == nullptr || !ReadHeader(context, &layout)) return damaged();
  if (layout.bit_depth != static_cast<int>(8 * kBytes) ||
      layout.color_type != PNG_COLOR_TYPE_GRAY) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s has %d bits a channel and colour type %d, expected a %zu-bit grey PNG",
                        file.c_str(),
                        layout.bit_depth,
                        layout.color_type,
                        8 * kBytes)};
  }
  image->width = layout.width;
  image->height = layout.height;
  const auto width = static_cast<size_t>(layout.width);
  // A row compresses by at most about 1030 : 1; what the file can't hold is not allocated.
  const size_t values = width * static_cast<size_t>(layout.height);
  if (kBytes * values / 1100 > context->input_left) {
    std::strncpy(context->message.data(), "too short for its size", context->message.size() - 1);
    return damaged();
  }
  image->gray.resize(values);
  std::vector<uint8_t*> rows;
  for (size_t row = 0; row < static_cast<size_t>(layout.height); ++row) {
    rows.push_back(reinterpret_cast<uint8_t*>(image->gray.data() + row * width));
  }
  if (!ReadRows(context, rows.data())) return damaged();
  return {};
}

}  // namespace

Result<std::vector<uint8_t>> EncodePng(const RgbImage& image) {
  Result<void> fits = CheckSize(image.width, image.height, image.rgb.size(), 3);
  if (!fits) return fits.error();
  return Encode({image.width, image.height, 8, PNG_COLOR_TYPE_RGB},
                image.rgb.data(),
                3 * static_cast<size_t>(image.width));
}

Result<std::vector<uint8_t>> EncodePng(const Gray16Image& image) {
  Result<void> fits = CheckSize(image.width, image.height, image.gray.size(), 1);
  if (!fits) return fits.error();
  return Encode({image.width, image.height, 16, PNG_COLOR_TYPE_GRAY},
                reinterpret_cast<const uint8_t*>(image.gray.data()),
                2 * static_cast<size_t>(image.width));
}

Result<void> WritePng(const std::filesystem::path& file, const RgbImage& image) {
  return Write(file, image);
}

Result<void> WritePng(const std::filesystem::path& file, const Gray16Image& image) {
  return Write(file, image);
}

namespace {

template <class Image>
Result<Image> ReadGray(const std::filesystem::path& file) {
  const Result<std::string> bytes = ReadFileBytes(file, kLargestFile);
  if (!bytes) return bytes.error();
  const auto* data = reinterpret_cast<const uint8_t*>(bytes->data());
  constexpr size_t kSignature = 8;
  if (bytes->size() < kSignature || png_sig_cmp(data, 0, kSignature) != 0) {
    return Error{ErrorCode::kCorrupt, Format("%s is no PNG file", file.c_str())};
  }
  PngContext context;
  context.input = data;
  context.input_left = bytes->size();
  context.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &context, OnError, OnWarning);
  if (context.png != nullptr) context.info = png_create_info_struct(context.png);
  Image image;
  const Result<void> read = Read(file, &context, &image);
  png_destroy_read_struct(&context.png, &context.info, nullptr);
  if (!read) return read.error();
  return image;
}

}  // namespace

Result<Gray16Image> ReadPng16(const std::filesystem::path& file) {
  return ReadGray<Gray16Image>(file);
}

Result<Gray8Image> ReadPng8(const std::filesystem::path& file) {
  return ReadGray<Gray8Image>(file);
}

}  // namespace vantage
