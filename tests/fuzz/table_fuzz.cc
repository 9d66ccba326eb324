// Arbitrary text as a table to import, CSV and GeoJSON: refused with InputError, or every row has a
// field for every column; and every field as a time of day.

#include "base/check.h"
#include "tools/scenario/import.h"
#include "tools/scenario/table.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace muster;
  using namespace muster::tools;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  for (const auto parse : {ParseCsv, ParseGeoJson}) {
    try {
      const Table table = parse(text, "table");
      for (const auto& row : table.rows) {
        MUSTER_CHECK(row.size() == table.columns.size());
        for (const std::string& field : row) {
          const std::optional<TimeUs> time = TimeOfDay(field);
          MUSTER_CHECK(!time || (*time >= 0 && *time < 24 * 60 * kMinuteUs));
        }
      }
    } catch (const InputError&) {
    }
  }
  return 0;
}
