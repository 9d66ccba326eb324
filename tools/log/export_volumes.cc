// Flights as volumes in space and time, as UTM services take them (ASTM F3548-21, Volume4D).
#include <fmt/format.h>

#include <GeographicLib/LocalCartesian.hpp>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/check.h"
#include "tools/files/pending_file.h"
#include "tools/log/air_record.h"
#include "tools/log/export.h"
#include "tools/log/mission_stream.h"

namespace muster::tools {
namespace {

using nlohmann::ordered_json;

/// A volume lasts no longer than that, so that a long way does not block all of its line for all of
/// its time.
constexpr double kLongest_s = 60;

class Volumes {
 public:
  Volumes(const Scenario& scenario, Origin origin, double ground_m, std::int64_t epoch_us)
      : minima_(*scenario.separation()),
        landing_(scenario.charging_points),
        local_(origin.latitude_deg, origin.longitude_deg),
        ground_m_(ground_m),
        epoch_us_(epoch_us) {}

  ordered_json Of(const Flight& flight) const {
    ordered_json volumes = ordered_json::array();
    const Trajectory path = TrajectoryOf(flight.uav, flight.clearance, flight.from_us, landing_);
    const double end_s = ToSeconds(flight.until_us - flight.from_us);
    for (std::size_t i = 0; i < path.knots.size(); ++i) {
      Trajectory::Knot from = path.knots[i], to = from;
      to.t_s = end_s;
      if (i + 1 < path.knots.size()) to = path.knots[i + 1];
      if (from.t_s >= end_s || (from.up_m <= 0 && to.up_m <= 0)) continue;
      const double seconds = to.t_s - from.t_s;
      const double share_flown = to.t_s > end_s ? (end_s - from.t_s) / seconds : 1;
      const bool stands = from.at == to.at && from.up_m == to.up_m;
      const int parts =
          stands ? 1 : std::max(1, static_cast<int>(std::ceil(share_flown * seconds / kLongest_s)));
      for (int part = 0; part < parts; ++part) {
        volumes.push_back(Volume(At(from, to, share_flown * part / parts),
                                 At(from, to, share_flown * (part + 1) / parts), flight.from_us));
      }
    }
    return volumes;
  }

 private:
  static Trajectory::Knot At(const Trajectory::Knot& a, const Trajectory::Knot& b, double share) {
    return {a.t_s + (b.t_s - a.t_s) * share, Lerp(a.at, b.at, share),
            a.up_m + (b.up_m - a.up_m) * share};
  }

  ordered_json Degrees(Point at) const {
    double latitude = 0, longitude = 0, height = 0;
    local_.Reverse(at.x_m, at.y_m, 0, latitude, longitude, height);
    return {{"lng", longitude}, {"lat", latitude}};
  }
  ordered_json Altitude(double up_m) const {
    return {{"value", ground_m_ + up_m}, {"reference", "W84"}, {"units", "M"}};
  }
  ordered_json Time(TimeUs at_us) const {
    return {{"value", IsoTime(epoch_us_ + at_us)}, {"format", "RFC3339"}};
  }

  ordered_json Volume(const Trajectory::Knot& a, const Trajectory::Knot& b, TimeUs from_us) const {
    // Half of each minimum: the volumes of UAVs that are kept apart across or up do not overlap.
    const double around_m = minima_.horizontal_m / 2, above_m = minima_.vertical_m / 2;
    ordered_json volume;
    const double way_m = Distance(a.at, b.at);
    if (way_m > 0) {
      const double x = (b.at.x_m - a.at.x_m) / way_m * around_m;
      const double y = (b.at.y_m - a.at.y_m) / way_m * around_m;
      ordered_json vertices = ordered_json::array();
      for (const Point corner :
           {Point{a.at.x_m - x + y, a.at.y_m - y - x}, Point{b.at.x_m + x + y, b.at.y_m + y - x},
            Point{b.at.x_m + x - y, b.at.y_m + y + x}, Point{a.at.x_m - x - y, a.at.y_m - y + x}}) {
        vertices.push_back(Degrees(corner));
      }
      volume["outline_polygon"] = {{"vertices", std::move(vertices)}};
    } else {
      volume["outline_circle"] = {{"center", Degrees(a.at)},
                                  {"radius", {{"value", around_m}, {"units", "M"}}}};
    }
    volume["altitude_lower"] = Altitude(std::max(0.0, std::min(a.up_m, b.up_m) - above_m));
    volume["altitude_upper"] = Altitude(std::max(a.up_m, b.up_m) + above_m);
    return {{"volume", std::move(volume)},
            {"time_start", Time(from_us + ToUs(a.t_s))},
            {"time_end", Time(from_us + ToUs(b.t_s))}};
  }

  const Separation minima_;
  const LandingPlaces landing_;
  const GeographicLib::LocalCartesian local_;
  const double ground_m_;
  const std::int64_t epoch_us_;
};

}  // namespace

void ExportVolumes(LogSource* source, const std::string& out, std::optional<Origin> origin,
                   double ground_m) {
  const MissionHead head = ReadMissionHead(source);
  if (head.scenario.separation() == nullptr) {
    throw InputError("scenario", "air", "none, or separation is off",
                     "a mission that keeps UAVs apart");
  }
  if (head.scenario.origin) origin = head.scenario.origin;
  if (!origin) {
    throw InputError("scenario", "origin", "none",
                     "latitude and longitude of the south-west corner, or --origin LAT,LON");
  }
  AirRecord air;
  std::set<std::int32_t> skipped;
  const auto at_end = ForEachMessage(
      source, head.run_id, [&](const Message& message, const Packet&, const Scenario& so_far) {
        if (const auto* m = std::get_if<clearances_t>(&message)) air.Take(*m, so_far);
        if (const auto* m = std::get_if<agent_states_t>(&message)) air.Take(*m, so_far);
        const auto* clock = std::get_if<clock_t>(&message);
        if (clock == nullptr || clock->tick < 1) return;
        const std::int32_t before = so_far.rules.DecisionAt(clock->tick - 1);
        if (before >= 0 && clock->required_decision < before) skipped.insert(before);
      });
  const Volumes volumes(*at_end, *origin, ground_m, head.epoch_us);
  std::string text = fmt::format("{{\"run_id\": {}, \"flights\": [", head.run_id);
  bool is_first = true;
  for (const Flight& flight : FlightsOf(air, *at_end, skipped)) {
    ordered_json list = volumes.Of(flight);
    if (list.empty()) continue;
    text += is_first ? "\n" : ",\n";
    text += ordered_json{{"uav", fmt::format("uav:{}", flight.clearance.uav)},
                         {"decision", flight.clearance.decision},
                         {"volumes", std::move(list)}}
                .dump();
    is_first = false;
  }
  WriteFile(out, text + "\n]}\n");
}

}  // namespace muster::tools
