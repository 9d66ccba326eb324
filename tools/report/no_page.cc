#include "tools/report/page.h"

namespace muster::tools {

std::string_view PageTemplate() { return ""; }

}  // namespace muster::tools
