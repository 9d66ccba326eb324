#include "tools/report/background.h"

#include <gtest/gtest.h>

#include "base/check.h"

namespace muster::tools {
namespace {

Scenario Haiti() {
  Scenario scenario;
  scenario.name = "haiti";
  scenario.width_m = scenario.height_m = 30'000;
  scenario.origin.emplace();
  scenario.origin->latitude_deg = 18.41;
  scenario.origin->longitude_deg = -72.47;
  return scenario;
}

std::string Feature(const std::string& geometry) {
  return R"({"type": "Feature", "properties": {"name": "it"}, "geometry": )" + geometry + "}";
}

TEST(Background, HoldsPointsLinesAndRingsInDegrees) {
  const auto read = [](const std::string& geometry) {
    return Background(Feature(geometry), "b.json", Haiti()).dump();
  };
  EXPECT_EQ(read(R"({"type": "Point", "coordinates": [-72.3, 18.5]})"),
            R"([[0,"it",[18.5,-72.3]]])");
  EXPECT_EQ(read(R"({"type": "LineString", "coordinates": [[-72.3, 18.5], [-72.2, 18.6]]})"),
            R"([[1,"it",[18.5,-72.3,18.6,-72.2]]])");
  EXPECT_EQ(read(R"({"type": "MultiPolygon", "coordinates":
                     [[[[-72.3, 18.5], [-72.2, 18.6], [-72.3, 18.6]]], [[[5, 5]]]]})"),
            R"([[2,"it",[18.5,-72.3,18.6,-72.2,18.6,-72.3]]])")
      << "what is far away is left out";
}

TEST(Background, RefusesWhatIsNoGeoJson) {
  EXPECT_THROW(Background("no", "b.json", Haiti()), InputError);
  EXPECT_THROW(Background(R"({"type": "Topology"})", "b.json", Haiti()), InputError);
  EXPECT_THROW(
      Background(Feature(R"({"type": "Point", "coordinates": [500000, 18]})"), "b.json", Haiti()),
      InputError);
  EXPECT_THROW(Background(Feature(R"({"type": "Polygon", "coordinates": 3})"), "b.json", Haiti()),
               InputError);
  Scenario nowhere = Haiti();
  nowhere.origin.reset();
  EXPECT_THROW(Background(Feature("null"), "b.json", nowhere), InputError);
}

}  // namespace
}  // namespace muster::tools
