#include "tools/report/figures.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/check.h"
#include "base/spawn.h"
#include "lcmtypes/bus/codec.h"
#include "tests/temporary_folder.h"
#include "tests/tools/fake_mission.h"
#include "tools/report/mission_feed.h"

namespace muster::tools {
namespace {

class Figures : public ::testing::Test {
 protected:
  Figures() {
    for (const Packet& packet : Encoded(MakeFakeMission())) feed_.Add(packet);
    feed_.Finish();
  }
  std::string Script(Figure figure, const std::string& name = "a run") const {
    return FigureScript(figure, {{name, &feed_.timeline()}}, {"svg"}, "out.svg");
  }
  static bool Has(const std::string& script, const std::string& text) {
    return script.find(text) != std::string::npos;
  }

  MissionFeed feed_;
};

/// The fake mission does its one sensing from minute 12 to minute 15.
TEST_F(Figures, ShowWhatTheMissionDid) {
  const std::string completion = Script(Figure::kCompletion);
  EXPECT_TRUE(Has(completion, "EOD\n0 0\n")) << completion;
  const auto& done = feed_.timeline().done().rows;
  ASSERT_FALSE(done.empty());
  const double share =
      100.0 * done.back().tasks / static_cast<double>(feed_.timeline().scenario().n_tasks());
  EXPECT_TRUE(Has(completion, fmt::format("{:.3f} {:.4f}\n",
                                          static_cast<double>(done.back().t_ms) / 60'000, share)))
      << completion;
  const std::string timeline = Script(Figure::kTimeline);
  EXPECT_TRUE(Has(timeline, "'UAVs' ")) << timeline;
  EXPECT_TRUE(Has(timeline, "title 'sensing'")) << timeline;
  const std::string map = Script(Figure::kMap);
  EXPECT_TRUE(Has(map, "1.0000 1.0000\n4.0000 1.0000\n")) << map;  // the UAV's first leg
  EXPECT_TRUE(Has(map, "title 'tasks done'")) << map;
  EXPECT_TRUE(Has(Script(Figure::kSpaceTime), "4.0000 1.0000 3.000\n"));
}

/// A run's name comes from a folder: it may hold what gnuplot takes for its own.
TEST_F(Figures, NamesAreNoCommands) {
  const std::string script = Script(Figure::kCompletion, "it's '; system(\"x\") #");
  EXPECT_TRUE(Has(script, "title 'it''s ''; system(\"x\") #'")) << script;
}

TEST_F(Figures, AreDrawnInEachFormat) {
  if (!FindProgram("gnuplot")) GTEST_SKIP() << "there is no gnuplot";
  const TemporaryFolder folder;
  const struct {
    const char *format, *begins;
  } formats[] = {{"pdf", "%PDF"}, {"svg", "<?xml"}, {"png", "\x89PNG"}};
  for (const auto& [format, begins] : formats) {
    for (const Figure figure :
         {Figure::kCompletion, Figure::kTimeline, Figure::kMap, Figure::kSpaceTime}) {
      const std::string file = folder.File(std::string("it's.") + format);
      WriteFigure(figure, {{"a run", &feed_.timeline()}}, {format}, file);
      std::ifstream in(file, std::ios::binary);
      std::ostringstream bytes;
      bytes << in.rdbuf();
      EXPECT_TRUE(bytes.str().starts_with(begins)) << format;
      EXPECT_GT(bytes.str().size(), 2000U) << format;
    }
  }
  EXPECT_THROW(
      WriteFigure(Figure::kMap, {{"a", &feed_.timeline()}}, {"pdf"}, folder.File("nowhere/a.pdf")),
      SystemError);
}

}  // namespace
}  // namespace muster::tools
