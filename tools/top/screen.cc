#include "tools/top/screen.h"

#include <curses.h>

#include <cstdlib>

namespace muster::tools {
namespace {
constexpr short kRed = 1;
}  // namespace

Screen::Screen() {
  initscr();
  cbreak();
  noecho();
  curs_set(0);
  nodelay(stdscr, TRUE);
  keypad(stdscr, TRUE);
  if (has_colors() && std::getenv("NO_COLOR") == nullptr) {
    start_color();
    use_default_colors();
    init_pair(kRed, COLOR_RED, -1);
  }
}

Screen::~Screen() { endwin(); }

std::size_t Screen::width() const { return static_cast<std::size_t>(getmaxx(stdscr)); }

void Screen::Show(const std::vector<TopView::Line>& lines) {
  erase();
  int y = 0;
  for (const TopView::Line& line : lines) {
    if (y >= getmaxy(stdscr)) break;
    attr_t look = A_NORMAL;
    if (line.look == TopView::Look::kHead) look = A_BOLD;
    if (line.look == TopView::Look::kBad) look = A_BOLD | static_cast<attr_t>(COLOR_PAIR(kRed));
    attr_set(look, line.look == TopView::Look::kBad ? kRed : 0, nullptr);
    mvaddstr(y++, 0, line.text.c_str());
  }
  attr_set(A_NORMAL, 0, nullptr);
  refresh();
}

bool Screen::QuitPressed() {
  for (int key = getch(); key != ERR; key = getch()) {
    if (key == 'q' || key == 'Q') return true;
  }
  return false;
}

}  // namespace muster::tools
