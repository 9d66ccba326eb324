#include "tools/report/page.h"

#include <fmt/format.h>
#include <glib.h>

#include <memory>

#include "base/check.h"
#include "tools/files/packing.h"

namespace muster::tools {
namespace {

std::string Escaped(const std::string& text) {
  const std::unique_ptr<gchar, decltype(&g_free)> markup(
      g_markup_escape_text(text.data(), static_cast<gssize>(text.size())), g_free);
  return markup.get();
}

/// The scene's script, which the page unpacks when the scene is opened; "" without one.
std::string PackedScene() {
  if (SceneScript().empty()) return "";
  return "<script type=\"text/x-muster-scene\">" + Base64(Deflate(std::string(SceneScript()))) +
         "</script>";
}

/// The template with what stands between its two marks.
std::string Fill(const std::string& title, std::string_view connect, const std::string& data) {
  constexpr std::string_view kTitle = "__MUSTER_TITLE__";
  constexpr std::string_view kConnect = "__MUSTER_CONNECT__";
  constexpr std::string_view kScene = "<!--MUSTER_SCENE-->";
  constexpr std::string_view kData = "<!--MUSTER_DATA-->";
  std::string_view rest = PageTemplate();
  std::string page;
  const auto put = [&](std::string_view mark, std::string_view text) {
    const std::size_t at = rest.find(mark);
    MUSTER_CHECK(at != std::string_view::npos, "{} is not in the template", mark);
    page.append(rest.substr(0, at)).append(text);
    rest.remove_prefix(at + mark.size());
  };
  put(kConnect, connect);
  put(kTitle, Escaped(title));
  put(kScene, PackedScene());
  put(kData, data);
  return page.append(rest);
}

}  // namespace

void RequirePage() {
  if (!PageTemplate().empty()) return;
  throw InputError(
      "this build has no report page: it was built without esbuild (scripts/run installs what is "
      "missing; then build again)");
}

std::string StaticPage(const std::string& title, const std::vector<std::string>& chunks) {
  std::string data;
  for (const std::string& chunk : chunks) {
    data.append(kPageMark).append(Base64(Deflate(chunk))).append("</script>\n");
  }
  return Fill(title, "'none'", data);
}

std::string LivePage(const std::string& title) {
  return Fill(title, "'self'", "<script type=\"text/x-muster-live\">/events</script>\n");
}

}  // namespace muster::tools
