#include "tools/files/packing.h"

#include <gio/gio.h>

#include <limits>
#include <memory>

#include "base/check.h"

namespace muster::tools {
namespace {

struct Unref {
  void operator()(gpointer object) const { g_object_unref(object); }
};

/// What the converter makes of all the bytes; none: it refuses them, or makes more of them.
std::optional<std::string> Convert(GConverter* converter, const std::string& bytes,
                                   std::size_t most_bytes) {
  std::string made;
  std::string buffer(1 << 16, '\0');
  std::size_t read = 0;
  while (true) {
    gsize in = 0, out = 0;
    GError* error = nullptr;
    const GConverterResult result =
        g_converter_convert(converter, bytes.data() + read, bytes.size() - read, buffer.data(),
                            buffer.size(), G_CONVERTER_INPUT_AT_END, &in, &out, &error);
    g_clear_error(&error);
    read += in;
    made.append(buffer, 0, out);
    if (result == G_CONVERTER_ERROR || made.size() > most_bytes) return {};
    if (result == G_CONVERTER_FINISHED) return made;
  }
}

}  // namespace

std::string Deflate(const std::string& bytes) {
  const std::unique_ptr<GZlibCompressor, Unref> zlib(
      g_zlib_compressor_new(G_ZLIB_COMPRESSOR_FORMAT_ZLIB, 6));
  auto packed = Convert(G_CONVERTER(zlib.get()), bytes, std::numeric_limits<std::size_t>::max());
  MUSTER_CHECK(packed.has_value());
  return *std::move(packed);
}

bool IsGzip(const std::string& bytes) { return bytes.starts_with("\x1f\x8b"); }

std::optional<std::string> Gunzip(const std::string& bytes, std::size_t most_bytes) {
  const std::unique_ptr<GZlibDecompressor, Unref> zlib(
      g_zlib_decompressor_new(G_ZLIB_COMPRESSOR_FORMAT_GZIP));
  return Convert(G_CONVERTER(zlib.get()), bytes, most_bytes);
}

std::string Base64(const std::string& bytes) {
  const std::unique_ptr<gchar, decltype(&g_free)> text(
      g_base64_encode(reinterpret_cast<const guchar*>(bytes.data()), bytes.size()), g_free);
  return text.get();
}

}  // namespace muster::tools
