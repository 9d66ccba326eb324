#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace muster::tools {

/// The page's template, bundled when Muster was built; "" when it was built without esbuild.
std::string_view PageTemplate();

/// The script of the page's scene in 3D; "" when Muster was built without three.js.
std::string_view SceneScript();

/// Every page with runs holds this text.
inline constexpr std::string_view kPageMark = "<script type=\"text/x-muster-run\">";

/// Throws InputError that says why there are no pages, when there is no template.
void RequirePage();

/// A page that holds its runs: `chunks` are PageChunk's, as text. It loads nothing from anywhere.
std::string StaticPage(const std::string& title, const std::vector<std::string>& chunks);

/// A page that is told by the server that it came from (server-sent events at /events).
std::string LivePage(const std::string& title);

}  // namespace muster::tools
