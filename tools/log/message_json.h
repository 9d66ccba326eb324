#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "protocol/inbox.h"

namespace muster::tools {

/// A message with the names of its fields in lcmtypes/types. Counts of arrays are left out, as an
/// array knows its length; the bytes of restore_t and answer_t are left out, and so is a number
/// that is NaN: a schema's "number" is never null.
nlohmann::ordered_json MessageJson(const Message& message);

/// JSON Schema of MessageJson of that type.
nlohmann::ordered_json MessageSchema(const Message& type);

}  // namespace muster::tools
