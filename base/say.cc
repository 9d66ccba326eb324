#include "base/say.h"

namespace muster {

void SayTo(std::FILE* out, std::string_view text) {
  static_cast<void>(std::fwrite(text.data(), 1, text.size(), out));
  static_cast<void>(std::fflush(out));
  std::clearerr(out);
}

}  // namespace muster
