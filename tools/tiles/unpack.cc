#include "tools/tiles/unpack.h"

#include <gio/gio.h>

#include <memory>

namespace muster::tools {
namespace {

struct Unref {
  void operator()(gpointer object) const { g_object_unref(object); }
};

}  // namespace

bool IsGzip(const std::string& bytes) { return bytes.starts_with("\x1f\x8b"); }

std::optional<std::string> Gunzip(const std::string& bytes, std::size_t most_bytes) {
  const std::unique_ptr<GZlibDecompressor, Unref> zlib(
      g_zlib_decompressor_new(G_ZLIB_COMPRESSOR_FORMAT_GZIP));
  std::string text;
  std::string buffer(1 << 16, '\0');
  std::size_t read = 0;
  while (text.size() <= most_bytes) {
    gsize in = 0, out = 0;
    GError* error = nullptr;
    const GConverterResult result = g_converter_convert(
        G_CONVERTER(zlib.get()), bytes.data() + read, bytes.size() - read, buffer.data(),
        buffer.size(), G_CONVERTER_INPUT_AT_END, &in, &out, &error);
    g_clear_error(&error);
    if (result == G_CONVERTER_ERROR) return {};
    read += in;
    text.append(buffer, 0, out);
    if (result == G_CONVERTER_FINISHED && text.size() <= most_bytes) return text;
  }
  return {};
}

}  // namespace muster::tools
