#include "model/task_reader.h"

#include <fmt/format.h>

namespace muster {

void ReadTaskTimes(const ObjectReader& object, Task* task) {
  const auto time = [&](std::string_view key, TimeUs* t) {
    if (object.Has(key)) *t = object.Time(key, kMinute);
  };
  const auto text = [&](std::string_view key, std::string* value) {
    if (object.Has(key)) *value = object.String(key);
  };
  time("reported_min", &task->reported_us);
  time("due_min", &task->due_us);
  time("expires_min", &task->expires_us);
  time("revisit_min", &task->revisit_us);
  if (const JsonValue* priority = object.Optional("priority")) {
    task->priority = static_cast<Priority>(
        object.ReadInteger("priority", *priority, 0, static_cast<std::int64_t>(kPriorities) - 1));
  }
  text("name", &task->name);
  text("external_id", &task->external_id);
  text("source", &task->source);
  text("note", &task->note);
  if (task->note.size() > kMostNote) {
    object.Fail("note", fmt::format("{} bytes", task->note.size()),
                fmt::format("at most {}", kMostNote));
  }
}

}  // namespace muster
