#include <cstdio>

#include "colmap_ext/mission/export_formats.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/text.h"
#include "mission/xml_writer.h"

namespace colmap_ext {
namespace {

std::string Coordinates(const MissionStop& stop, bool is_absolute) {
  char text[96];
  std::snprintf(text, sizeof text, "%.9f,%.9f,%.3f", stop.lon_deg, stop.lat_deg,
                is_absolute ? *stop.height.amsl_m : stop.height.relative_m);
  return text;
}

void AddLine(const Mission& mission, const BatteryFlight& flight, const std::string& name,
             bool is_absolute, XmlWriter* xml) {
  // A line needs two places: one alone is a point.
  const bool is_point = flight.first_waypoint == flight.last_waypoint;
  xml->Open("Placemark");
  xml->Leaf("name", name);
  xml->Open(is_point ? "Point" : "LineString");
  xml->Leaf("altitudeMode", is_absolute ? "absolute" : "relativeToGround");
  std::string coordinates;
  for (std::size_t i = flight.first_waypoint; i <= flight.last_waypoint; ++i) {
    coordinates += (i == flight.first_waypoint ? "" : " ");
    coordinates += Coordinates(mission.stops[i], is_absolute);
  }
  xml->Leaf("coordinates", coordinates);
  xml->Close();
  xml->Close();
}

void AddView(const MissionStop& stop, bool is_absolute, XmlWriter* xml) {
  xml->Open("Placemark");
  xml->Leaf("name", "view " + std::to_string(stop.view_id));
  xml->Open("ExtendedData");
  const auto add = [&](const std::string& name, const std::string& value) {
    xml->Open("Data", " name=\"" + name + "\"");
    xml->Leaf("value", value);
    xml->Close();
  };
  add("heading_deg", FormatNumber("%.3f", HeadingDeg(stop.direction)));
  add("pitch_deg", FormatNumber("%.3f", RadToDeg(stop.direction.pitch_rad)));
  add("relative_height_m", FormatNumber("%.3f", stop.height.relative_m));
  xml->Close();
  xml->Open("Point");
  xml->Leaf("altitudeMode", is_absolute ? "absolute" : "relativeToGround");
  xml->Leaf("coordinates", Coordinates(stop, is_absolute));
  xml->Close();
  xml->Close();
}

}  // namespace

std::string Kml(const Mission& mission, const MissionOptions& options) {
  if (options.height_reference == "ellipsoidal") {
    throw Error("KML: its heights are relative or amsl, not ellipsoidal");
  }
  const bool is_absolute = options.height_reference == "amsl";
  XmlWriter xml;
  xml.Open("kml", " xmlns=\"http://www.opengis.net/kml/2.2\"");
  xml.Open("Document");
  xml.Leaf("name", "colmap_ext");
  xml.Leaf("description", is_absolute ? "Heights are above sea level (EGM96)."
                                      : "Heights are above the take-off place, drawn as above the "
                                        "ground.");
  std::vector<BatteryFlight> flights = mission.flights;
  if (flights.empty()) {
    flights.emplace_back();
    flights.back().last_waypoint = mission.stops.size() - 1;
  }
  for (std::size_t i = 0; i < flights.size(); ++i) {
    AddLine(mission, flights[i], "flight " + std::to_string(i + 1), is_absolute, &xml);
  }
  for (const MissionStop& stop : mission.stops) {
    if (stop.view_id >= 0) AddView(stop, is_absolute, &xml);
  }
  xml.Close();
  xml.Close();
  return xml.text();
}

}  // namespace colmap_ext
