#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "model/generator.h"
#include "tools/scenario/table.h"

namespace muster::tools {

/// Settings on the places of real data sets (docs/guide/import.md), out of the tables of a data
/// folder, each read once.
class ImportedSettings {
 public:
  /// "": no data folder. Throws InputError when the folder lacks a table.
  explicit ImportedSettings(std::string data_folder);

  bool HasData() const { return !data_folder_.empty(); }
  static std::vector<std::string> Names();
  static bool Has(const std::string& name);
  /// Area and numbers of that setting, under its name.
  static GeneratorSettings ShapeOf(const std::string& name);

  /// Reads what Make(name, ...) needs, so that processes forked later share it. Throws InputError,
  /// SystemError.
  void Prepare(const std::string& name) { Load(name); }
  /// SHA-256 of the setting's table.
  const std::string& Sha256Of(const std::string& name) { return Load(name).sha256; }

  /// As `muster import` makes it; `are_reports`: with --arrivals rows.
  Scenario Make(const std::string& name, const GeneratorSettings& settings, std::uint64_t seed,
                bool are_reports);

 private:
  struct Places {
    Table table;
    std::string sha256;
  };
  const Places& Load(const std::string& name);

  std::string data_folder_;
  std::map<std::string, Places> places_;  ///< by file
};

}  // namespace muster::tools
