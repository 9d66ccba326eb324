#pragma once

#include <vector>

#include "tools/top/top_view.h"

namespace muster::tools {

/// The terminal as a whole, through ncurses; as it was when destroyed. One at a time.
class Screen {
 public:
  Screen();
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  std::size_t width() const;
  void Show(const std::vector<TopView::Line>& lines);
  /// Whether q was pressed since the last call.
  bool QuitPressed();
};

}  // namespace muster::tools
