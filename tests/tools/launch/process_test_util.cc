#include "tests/tools/launch/process_test_util.h"

#include <fstream>
#include <iterator>

namespace muster::tools {

std::string TextOf(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace muster::tools
