#pragma once

#include <functional>
#include <optional>
#include <string>

namespace muster::tools {

/// What a file of the scene is to be.
enum class SceneKind { kPicture, kFilm };

/// By the file's suffix, .png or .webm. Throws InputError on any other, and when there is something
/// else at `file`, or this build has no scene.
SceneKind SceneKindOf(const std::string& file);

/// Told how many of a film's frames are taken.
using FilmProgress = std::function<void(int taken, int of)>;

/// The scene of a page, drawn by the Chromium of this machine: a PNG of the moment that `link` says
/// (as in the page's address, "t=4800&sel=uav:2"), or a WebM of all the mission. Takes seconds for
/// a picture, minutes for a film without a graphics card. Nothing when a signal asked to stop.
/// Throws SystemError.
std::optional<std::string> FilmScene(const std::string& page, SceneKind kind,
                                     const std::string& link, const FilmProgress& progress);

}  // namespace muster::tools
