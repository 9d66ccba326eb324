#include "tools/report/gshhg.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <type_traits>
#include <utility>

#include "base/check.h"

namespace muster::tools {
namespace {

constexpr const char* kFolder = "/usr/share/gmt-gshhg";
constexpr const char* kPackages = "Debian's gmt-gshhg-full and libnetcdf19";
constexpr int kGlobal = -1;  ///< NC_GLOBAL
constexpr int kGroundingLine = 6;
constexpr std::size_t kMostSegments = 100'000;
constexpr std::size_t kMostPoints = 10'000'000;

/// libnetcdf's C interface (netcdf.h, version 4.9), as far as it is used here.
struct NetCdf {
  int (*open)(const char* path, int mode, int* file);
  int (*close)(int file);
  int (*find)(int file, const char* name, int* variable);
  int (*get)(int file, int variable, const std::size_t* start, const std::size_t* count, int* to);
  int (*attribute_length)(int file, int variable, const char* name, std::size_t* length);
  int (*attribute)(int file, int variable, const char* name, char* to);
  const char* (*error)(int);
};

/// Stays loaded: HDF5 beneath it does not like to be taken away.
const NetCdf* LoadNetCdf() {
  static const auto loaded = []() -> std::unique_ptr<NetCdf> {
    void* library = dlopen("libnetcdf.so.19", RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (library == nullptr) return nullptr;
    auto found = std::make_unique<NetCdf>();
    bool whole = true;
    const auto find = [&](const char* name, auto* function) {
      *function = reinterpret_cast<std::remove_pointer_t<decltype(function)>>(dlsym(library, name));
      whole = whole && *function != nullptr;
    };
    find("nc_open", &found->open);
    find("nc_close", &found->close);
    find("nc_inq_varid", &found->find);
    find("nc_get_vara_int", &found->get);
    find("nc_inq_attlen", &found->attribute_length);
    find("nc_get_att_text", &found->attribute);
    find("nc_strerror", &found->error);
    return whole ? std::move(found) : nullptr;
  }();
  return loaded.get();
}

class GshhgFile {
 public:
  GshhgFile(const NetCdf& netcdf, const std::string& path) : netcdf_(netcdf), path_(path) {
    Check(netcdf_.open(path.c_str(), 0, &file_));
  }
  ~GshhgFile() { netcdf_.close(file_); }
  GshhgFile(const GshhgFile&) = delete;
  GshhgFile& operator=(const GshhgFile&) = delete;

  std::vector<int> Read(const char* variable, std::size_t start, std::size_t count) const {
    int id = 0;
    Check(netcdf_.find(file_, variable, &id), variable);
    std::vector<int> values(count);
    if (count > 0) Check(netcdf_.get(file_, id, &start, &count, values.data()), variable);
    return values;
  }

  /// "" without one.
  std::string Attribute(const char* name) const {
    std::size_t length = 0;
    if (netcdf_.attribute_length(file_, kGlobal, name, &length) != 0 || length > 1000) return "";
    std::string text(length, '\0');
    if (netcdf_.attribute(file_, kGlobal, name, text.data()) != 0) return "";
    while (!text.empty() && text.back() == '\0') text.pop_back();
    return text;
  }

  [[noreturn]] void Refuse(const std::string& what) const {
    throw InputError(path_ + ": no binned file of GSHHG: " + what);
  }

 private:
  void Check(int result, const char* variable = nullptr) const {
    if (result == 0) return;
    Refuse((variable == nullptr ? "" : std::string(variable) + ": ") + netcdf_.error(result));
  }

  const NetCdf& netcdf_;
  std::string path_;
  int file_ = 0;
};

/// Bins are numbered from the north-western one, in rows.
ShoreGrid::Bin ReadBin(const GshhgFile& file, const ShoreGrid& grid, int column, int row) {
  const std::size_t bin =
      static_cast<std::size_t>(grid.rows - 1 - row) * static_cast<std::size_t>(grid.columns) +
      static_cast<std::size_t>(column);
  ShoreGrid::Bin read;
  const int levels = file.Read("Embedded_node_levels_in_a_bin", bin, 1)[0];
  for (int i = 0; i < 4; ++i) {
    read.corners[static_cast<std::size_t>(i)] = (levels >> (9 - 3 * i)) & 7;
  }
  const int first = file.Read("Id_of_first_segment_in_a_bin", bin, 1)[0];
  const int n = file.Read("N_segments_in_a_bin", bin, 1)[0] & 0xffff;
  if (n == 0) return read;
  if (first < 0 || static_cast<std::size_t>(n) > kMostSegments) file.Refuse("its segments");
  const auto begin = static_cast<std::size_t>(first), count = static_cast<std::size_t>(n);
  const auto info = file.Read("Embedded_npts_levels_exit_entry_for_a_segment", begin, count);
  const auto start = file.Read("Id_of_first_point_in_a_segment", begin, count);
  for (std::size_t i = 0; i < count; ++i) {
    // Antarctica is there twice, to where its ice ends and to where that stands on the ground.
    if (((info[i] >> 6) & 7) == kGroundingLine) continue;
    const auto points = static_cast<std::size_t>(static_cast<unsigned>(info[i]) >> 9);
    if (start[i] < 0 || points > kMostPoints) file.Refuse("its points");
    const auto from = static_cast<std::size_t>(start[i]);
    const auto x = file.Read("Relative_longitude_from_SW_corner_of_bin", from, points);
    const auto y = file.Read("Relative_latitude_from_SW_corner_of_bin", from, points);
    auto& segment = read.segments.emplace_back();
    for (std::size_t k = 0; k < points; ++k) segment.push_back({x[k] & 0xffff, y[k] & 0xffff});
  }
  return read;
}

}  // namespace

ShoreGrid OpenGshhg(const std::string& path) {
  const NetCdf* netcdf = LoadNetCdf();
  if (netcdf == nullptr) {
    throw InputError(path + ": reading it needs libnetcdf (Debian: libnetcdf19)");
  }
  const auto file = std::make_shared<const GshhgFile>(*netcdf, path);
  ShoreGrid grid;
  grid.bin_deg = file->Read("Bin_size_in_minutes", 0, 1)[0] / 60.0;
  grid.columns = file->Read("N_bins_in_360_longitude_range", 0, 1)[0];
  grid.rows = file->Read("N_bins_in_180_degree_latitude_range", 0, 1)[0];
  if (!(grid.bin_deg > 0 && grid.columns > 0 && grid.rows > 0 && grid.columns <= 360 * 60 &&
        grid.rows <= 180 * 60)) {
    file->Refuse("its bins");
  }
  const std::string version = file->Attribute("version");
  grid.source = version.empty() ? "GSHHG" : "GSHHG " + version;
  grid.read = [file, grid](int column, int row) { return ReadBin(*file, grid, column, row); };
  return grid;
}

std::string InstalledGshhg() {
  for (const char* resolution : {"f", "h", "i", "l"}) {
    std::string path = fmt::format("{}/binned_GSHHS_{}.nc", kFolder, resolution);
    std::error_code none;
    if (std::filesystem::exists(path, none)) return path;
  }
  return "";
}

nlohmann::ordered_json CoastOf(const std::string& choice, const Scenario& scenario,
                               std::string* missing) {
  const bool is_auto = choice == "auto";
  if (choice == "none" || (is_auto && !scenario.origin)) return {};
  if (!scenario.origin) {
    throw InputError(fmt::format("{}: scenario '{}' has no origin, so a coast has no place on it",
                                 choice, scenario.name));
  }
  const std::string file = is_auto ? InstalledGshhg() : choice;
  if (!file.empty()) {
    try {
      return Coast(OpenGshhg(file), scenario);
    } catch (const InputError& error) {
      if (!is_auto) throw;
      *missing = fmt::format("no coast: {}", error.what());
      return {};
    }
  }
  *missing = fmt::format("no coast: {} draw one; --coast none to do without", kPackages);
  return {};
}

}  // namespace muster::tools
