#pragma once

#include "base/object_reader.h"
#include "model/scenario.h"

namespace muster {

/// Reads what a task has in version 2 of the file only: times, priority, names.
void ReadTaskTimes(const ObjectReader& object, Task* task);

}  // namespace muster
