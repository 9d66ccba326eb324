// Alerts and forms of other systems, read. The alerts are made up after the structure of OASIS
// CAP 1.2, section 3.2; the submissions after KoboToolbox's API v2 ("data").
#include "tools/orders/alert_feed.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/check.h"

namespace muster::tools {
namespace {

using Fields = nlohmann::ordered_json;

struct AlertParts {
  std::string id = "a1", status = "Actual", kind = "Alert", references = "", severity = "Severe",
              urgency = "Immediate", area = "<circle>18.5,-72.3 1.5</circle>", more = "";
};

std::string Alert(const AlertParts& parts) {
  return fmt::format(
      R"(<alert xmlns="urn:oasis:names:tc:emergency:cap:1.2"><identifier>{}</identifier>
<sender>civil@example.org</sender><sent>2010-01-16T09:10:00-05:00</sent><status>{}</status>
<msgType>{}</msgType><scope>Public</scope><references>{}</references>
<info><language>en</language><event>Collapse</event><urgency>{}</urgency><severity>{}</severity>
<certainty>Observed</certainty>{}<headline>School in ruins</headline><area><areaDesc>North</areaDesc>{}</area></info></alert>)",
      parts.id, parts.status, parts.kind, parts.references, parts.urgency, parts.severity,
      parts.more, parts.area);
}

Reports Read(const AlertParts& parts, const std::string& start = "",
             const char* status = "Actual") {
  return ReadCap(Alert(parts), "a.xml", status, start.empty() ? std::nullopt : ParseMoment(start));
}

TEST(Cap, AnAreaIsATaskAtItsCentre) {
  const Reports read = Read({});
  ASSERT_EQ(read.reports.size(), 1U);
  const Report& report = read.reports[0];
  EXPECT_EQ(report.key, "civil@example.org,a1,2010-01-16T09:10:00-05:00");
  EXPECT_EQ(report.sent, "2010-01-16T14:10:00+00:00");
  ASSERT_EQ(report.tasks.size(), 1U);
  EXPECT_EQ(report.tasks[0], Fields::parse(R"({"priority": 3, "name": "School in ruins",
    "external_id": "a1", "source": "civil@example.org", "due_in_min": 30.0,
    "latitude_deg": 18.5, "longitude_deg": -72.3})"));
}

TEST(Cap, AnLShapedPolygonHasItsCentreOfArea) {
  // Squares of area 3 and 1 with centres at (1.5, .5) and (.5, 1.5): (1.25, .75) from the corner.
  AlertParts parts;
  parts.area = "<polygon>10,20 10,23 11,23 11,21 12,21 12,20 10,20</polygon>";
  const Reports read = Read(parts);
  ASSERT_EQ(read.reports.size(), 1U);
  EXPECT_NEAR(read.reports[0].tasks[0]["latitude_deg"].get<double>(), 10.75, 1e-6);
  EXPECT_NEAR(read.reports[0].tasks[0]["longitude_deg"].get<double>(), 21.25, 1e-6);
}

TEST(Cap, SeverityAndUrgencyArePriorityAndDueTime) {
  const auto priority = [](const char* severity, const char* urgency) {
    AlertParts parts;
    parts.severity = severity, parts.urgency = urgency;
    return Read(parts).reports.at(0).tasks.at(0)["priority"].get<int>();
  };
  EXPECT_EQ(priority("Extreme", "Immediate"), 3);
  EXPECT_EQ(priority("Extreme", "Future"), 2);
  EXPECT_EQ(priority("Severe", "Expected"), 2);
  EXPECT_EQ(priority("Moderate", "Immediate"), 2);
  EXPECT_EQ(priority("Moderate", "Unknown"), 1);
  EXPECT_EQ(priority("Unknown", "Unknown"), 1);
  EXPECT_EQ(priority("Minor", "Expected"), 0);
  EXPECT_EQ(priority("Minor", "Past"), 0);
  // 9:10 is minute 10; an hour from then, but not after the alert has ended.
  AlertParts parts;
  parts.urgency = "Expected";
  const char* start = "2010-01-16T09:00:00-05:00";
  EXPECT_EQ(Read(parts, start).reports.at(0).tasks.at(0)["due_min"], 70.0);
  parts.more = "<expires>2010-01-16T14:40:00Z</expires>";
  const Fields task = Read(parts, start).reports.at(0).tasks.at(0);
  EXPECT_EQ(task["due_min"], 40.0);
  EXPECT_EQ(task["expires_min"], 40.0);
  EXPECT_FALSE(Read(parts).reports.at(0).tasks.at(0).contains("expires_min"));
}

TEST(Cap, UpdatesAndCancelsSayWhatTheyReplace) {
  AlertParts parts;
  parts.kind = "Update", parts.references = " x,1,t\n y,2,t ";
  EXPECT_EQ(Read(parts).reports.at(0).replaces, (std::vector<std::string>{"x,1,t", "y,2,t"}));
  parts.kind = "Cancel", parts.area = "";
  const Reports cancel = Read(parts);
  ASSERT_EQ(cancel.reports.size(), 1U);
  EXPECT_TRUE(cancel.reports[0].tasks.empty());
  EXPECT_EQ(cancel.reports[0].replaces.size(), 2U);
}

TEST(Cap, SeveralAlertsInAFeedWithPrefixesAndLanguages) {
  std::string twice = Alert({});
  const std::size_t info = twice.find("<info>"), end = twice.find("</alert>");
  std::string french = twice.substr(info, end - info);
  french.replace(french.find(">en<"), 4, ">fr<");
  twice.insert(end, french);
  const Reports read = ReadCap("<feed><entry>" + twice + "</entry><entry>" +
                                   Alert({.id = "a2", .status = "Exercise"}) + "</entry></feed>",
                               "f", "Actual", std::nullopt);
  ASSERT_EQ(read.reports.size(), 1U);
  EXPECT_EQ(read.reports[0].tasks.size(), 1U);
  ASSERT_EQ(read.refused.size(), 1U);
  EXPECT_EQ(read.refused[0], "f: alert a2: status is 'Exercise', expected Actual");
  const Reports prefixed = ReadCap(
      "<c:alert "
      "xmlns:c='u'><c:identifier>i</c:identifier><c:sender>s</c:sender><c:sent>2010-01-16T09:10:00Z"
      "</c:sent><c:status>Actual</c:status><c:msgType>Cancel</c:msgType></c:alert>",
      "f", "Actual", std::nullopt);
  EXPECT_EQ(prefixed.reports.at(0).key, "s,i,2010-01-16T09:10:00Z");
}

TEST(Cap, AHeadlineOverSeveralLinesIsAName) {
  std::string alert = Alert({});
  alert.replace(alert.find("School in"), 9, "School\n   in");
  EXPECT_EQ(ReadCap(alert, "f", "Actual", {}).reports.at(0).tasks.at(0)["name"], "School in ruins");
}

TEST(Cap, WhatIsWrongIsNamed) {
  const auto refused = [](const AlertParts& parts) { return Read(parts).refused.at(0); };
  EXPECT_EQ(refused({.area = "<circle>18.5 -72.3 1</circle>"}),
            "a.xml: alert a1: circle is '18.5 -72.3 1', expected LAT,LON RADIUS");
  EXPECT_EQ(refused({.area = "<polygon>91,2 3,4 5,6 91,2</polygon>"}),
            "a.xml: alert a1: polygon is '91,2', expected LAT,LON");
  EXPECT_EQ(refused({.area = "<polygon>1,2 3,4 1,2</polygon>"}),
            "a.xml: alert a1: polygon is '1,2 3,4 1,2', expected four places or more");
  EXPECT_EQ(refused({.area = "<geocode/>"}),
            "a.xml: alert a1: area is '', expected a circle or a polygon");
  EXPECT_EQ(refused({.kind = "Ack"}),
            "a.xml: alert a1: msgType is 'Ack', expected Alert, Update or Cancel");
  EXPECT_EQ(refused({.id = ""}), "a.xml: an alert has no identifier");
  EXPECT_THROW(ReadCap("<alert><b></alert>", "f", "Actual", {}), InputError);
  EXPECT_THROW(ReadCap("<rss/>", "f", "Actual", {}), InputError);
  // A document type with entities in entities is not unfolded.
  const std::string bomb = "<!DOCTYPE a [<!ENTITY x \"1111111111\"><!ENTITY y \"&x;&x;&x;&x;\">]>" +
                           Alert({.more = "<note>&y;&y;</note>"});
  EXPECT_EQ(ReadCap(bomb, "f", "Actual", {}).reports.size(), 1U);
}

Fields TaskOf(const Table& row) {
  Fields task;
  for (std::size_t i = 0; i < row.columns.size(); ++i) task[row.columns[i]] = row.rows[0][i];
  return task;
}

TEST(Kobo, SubmissionsAreRows) {
  const char* api = R"({"count": 2, "next": null, "results": [
    {"_id": 7, "_uuid": "u1", "_geolocation": [18.5, -72.3], "place/what": "School", "urgent": "high",
     "_submission_time": "2010-01-16T14:10:00"},
    {"_uuid": "u2", "_geolocation": [null, null], "meta/deprecatedID": "uuid:u1"}, {"_id": 3}]})";
  const Reports read = ReadKobo(api, "k.json", {"urgent"}, TaskOf);
  ASSERT_EQ(read.reports.size(), 2U);
  EXPECT_EQ(read.reports[0].key, "u1");
  EXPECT_EQ(read.reports[0].sent, "2010-01-16T14:10:00");
  const Fields& task = read.reports[0].tasks.at(0);
  EXPECT_EQ(task["latitude"], "18.5");
  EXPECT_EQ(task["what"], "School");
  EXPECT_EQ(task["place/what"], "School");
  EXPECT_EQ(task["external_id"], "u1");
  EXPECT_EQ(read.reports[1].replaces, std::vector<std::string>{"u1"});
  EXPECT_EQ(read.reports[1].tasks.at(0)["urgent"], "");
  ASSERT_EQ(read.refused.size(), 1U);
  EXPECT_EQ(read.refused[0], "k.json: submission 3: it has no _uuid");
}

TEST(Kobo, WhatIsNoSubmissionIsRefused) {
  EXPECT_THROW(ReadKobo("{", "k", {}, TaskOf), InputError);
  EXPECT_THROW(ReadKobo("3", "k", {}, TaskOf), InputError);
  const std::string deep = std::string(1'000'000, '[') + std::string(1'000'000, ']');
  EXPECT_THROW(ReadKobo(R"({"_uuid": "u", "x": )" + deep + "}", "k", {}, TaskOf), InputError);
  EXPECT_EQ(ReadKobo("[1, null, \"x\"]", "k", {}, TaskOf).refused.size(), 3U);
  EXPECT_EQ(ReadKobo(R"({"_uuid": "one", "_geolocation": 5})", "k", {}, TaskOf).reports.size(), 1U);
}

}  // namespace
}  // namespace muster::tools
