// A target with a fault planted in it, for the tests of the replay: it dies of a beginning that is
// three bytes long, or of as much memory as an input asks for.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 3 && data[0] == 'a') std::abort();
  if (size == 4 && data[0] == 'm') {
    std::vector<char> much(std::size_t{1} << 34);
    much[size] = 1;
    return much[size] == 1 ? 0 : 1;
  }
  return 0;
}
