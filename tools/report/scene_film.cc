#include "tools/report/scene_film.h"

#include <fmt/format.h>
#include <glib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string_view>

#include "base/check.h"
#include "tools/files/pending_file.h"
#include "tools/files/scratch_folder.h"
#include "tools/host/stop_signals.h"
#include "tools/report/chromium.h"
#include "tools/report/page.h"

namespace muster::tools {
namespace {

constexpr int kPictureWidth = 1920, kPictureHeight = 1080;
constexpr int kFilmWidth = 1280, kFilmHeight = 720;
constexpr int kFilmSeconds = 20, kFramesPerSecond = 15;
constexpr double kTurn = 0.7;    ///< of the camera in all, radians
constexpr int kFramesACall = 6;  ///< so that progress is told

constexpr std::string_view kPng = "\x89PNG";
constexpr std::string_view kWebm = "\x1a\x45\xdf\xa3";

std::string Unpacked(const std::string& base64) {
  gsize size = 0;
  const std::unique_ptr<guchar, decltype(&g_free)> bytes(g_base64_decode(base64.c_str(), &size),
                                                         g_free);
  return {reinterpret_cast<const char*>(bytes.get()), size};
}

/// Waits until the page has loaded and drawn the scene, or says why it cannot.
constexpr std::string_view kReady = R"js((async () => {
  const frame = () => new Promise((resolve) => requestAnimationFrame(resolve));
  const said = (id) => document.getElementById(id)?.textContent ?? "";
  while (!window.muster?.film || document.getElementById("scene").dataset.drawn === undefined) {
    await frame();
    if (said("problem")) throw new Error(said("problem"));
    if (document.getElementById("scene")?.hidden) throw new Error(said("scene-problem"));
  }
})())js";

}  // namespace

SceneKind SceneKindOf(const std::string& file) {
  const std::string suffix = std::filesystem::path(file).extension();
  if (suffix != ".png" && suffix != ".webm") {
    throw InputError("command line", "--scene", file, "a file to write, FILE.png or FILE.webm");
  }
  if (SceneScript().empty()) {
    throw InputError(
        "this build has no scene: it was built without three.js (scripts/run installs what is "
        "missing; then build again)");
  }
  const SceneKind kind = suffix == ".png" ? SceneKind::kPicture : SceneKind::kFilm;
  std::ifstream there(file, std::ios::binary);
  std::string start(kPng.size(), '\0');
  there.read(start.data(), static_cast<std::streamsize>(start.size()));
  if (there.gcount() > 0 && start != (kind == SceneKind::kPicture ? kPng : kWebm)) {
    throw InputError("command line", "--scene", file + ", a file of another kind",
                     "a new file, or a picture or film to make again");
  }
  return kind;
}

std::optional<std::string> FilmScene(const std::string& page, SceneKind kind,
                                     const std::string& link, const FilmProgress& progress) {
  const StopSignals stop;
  const ScratchFolder folder("muster_scene");
  const std::string file = folder.path() + "/page.html";
  WriteFile(file, page);
  const bool picture = kind == SceneKind::kPicture;
  const std::string looks = link.find("look=") == std::string::npos ? "&look=scene" : "";
  Chromium chromium("file://" + file + "#" + link + looks, folder.path(),
                    picture ? kPictureWidth : kFilmWidth, picture ? kPictureHeight : kFilmHeight);
  chromium.Evaluate(kReady);
  if (picture) return Unpacked(chromium.Evaluate("muster.film.picture()"));
  const std::string n = chromium.Evaluate(
      fmt::format("muster.film.begin({}, {}, {})", kFilmSeconds, kFramesPerSecond, kTurn));
  const int frames = std::stoi(n);
  for (int i = 0; i < frames; i += kFramesACall) {
    if (stop.count() > 0) return std::nullopt;
    chromium.Evaluate(fmt::format("muster.film.take({}, {})", i, kFramesACall));
    progress(std::min(i + kFramesACall, frames), frames);
  }
  return Unpacked(chromium.Evaluate("muster.film.end()"));
}

}  // namespace muster::tools
