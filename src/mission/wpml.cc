#include <minizip/zip.h>

#include <algorithm>
#include <cstdio>

#include "colmap_ext/mission/export_formats.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/text.h"
#include "mission/xml_writer.h"

namespace colmap_ext {
namespace {

constexpr const char* kNamespaces =
    " xmlns=\"http://www.opengis.net/kml/2.2\" xmlns:wpml=\"http://www.dji.com/wpmz/1.0.2\"";

std::string Number(double value) { return FormatNumber("%.3f", value); }

// In (-180, 180].
std::string Heading(const ViewDirection& direction) {
  return Number(RadToDeg(NormalizeAngle(direction.yaw_rad)));
}

class WpmlWriter {
 public:
  WpmlWriter(const Mission& mission, const MissionOptions& options)
      : mission_(mission),
        options_(options),
        is_ellipsoidal_(options.height_reference == "ellipsoidal") {}

  std::string Template() {
    Begin();
    xml_.Open("Folder");
    Leaf("templateType", "waypoint");
    Leaf("templateId", "0");
    xml_.Open("wpml:waylineCoordinateSysParam");
    Leaf("coordinateMode", "WGS84");
    Leaf("heightMode", is_ellipsoidal_ ? "EGM96" : "relativeToStartPoint");
    Leaf("positioningType", "GPS");
    xml_.Close();
    Leaf("autoFlightSpeed", Number(options_.speed_m_s));
    Leaf("gimbalPitchMode", "usePointSetting");
    Leaf("globalWaypointTurnMode", "toPointAndStopWithDiscontinuityCurvature");
    Leaf("globalUseStraightLine", "1");
    for (std::size_t i = 0; i < mission_.stops.size(); ++i) AddPlacemark(i, true);
    return End();
  }

  std::string Waylines() {
    Begin();
    xml_.Open("Folder");
    Leaf("templateId", "0");
    Leaf("executeHeightMode", is_ellipsoidal_ ? "WGS84" : "relativeToStartPoint");
    Leaf("waylineId", "0");
    Leaf("distance", Number(mission_.length_m));
    Leaf("duration", Number(mission_.duration_s));
    Leaf("autoFlightSpeed", Number(options_.speed_m_s));
    for (std::size_t i = 0; i < mission_.stops.size(); ++i) AddPlacemark(i, false);
    return End();
  }

 private:
  void Leaf(const std::string& name, const std::string& value) { xml_.Leaf("wpml:" + name, value); }

  void Begin() {
    xml_.Open("kml", kNamespaces);
    xml_.Open("Document");
    xml_.Open("wpml:missionConfig");
    Leaf("flyToWaylineMode", "safely");
    Leaf("finishAction", "goHome");
    Leaf("exitOnRCLost", "executeLostAction");
    Leaf("executeRCLostAction", "goBack");
    Leaf("takeOffSecurityHeight", Number(SecurityHeight()));
    Leaf("takeOffRefPoint", RefPoint());
    Leaf("globalTransitionalSpeed", Number(options_.speed_m_s));
    Leaf("globalRTHHeight", Number(HighestStop()));
    xml_.Open("wpml:droneInfo");
    Leaf("droneEnumValue", std::to_string(options_.dji_drone));
    Leaf("droneSubEnumValue", "0");
    xml_.Close();
    xml_.Open("wpml:payloadInfo");
    Leaf("payloadEnumValue", std::to_string(options_.dji_payload));
    Leaf("payloadSubEnumValue", "0");
    Leaf("payloadPositionIndex", "0");
    xml_.Close();
    xml_.Close();
  }

  std::string End() {
    xml_.Close();
    xml_.Close();
    xml_.Close();
    return xml_.text();
  }

  double HighestStop() const {
    double highest = options_.takeoff_height_m;
    for (const MissionStop& stop : mission_.stops) {
      highest = std::max(highest, stop.height.relative_m);
    }
    return highest;
  }

  // "safely": up to this height before the way to the first waypoint. DJI takes 1.2 … 1500 m.
  double SecurityHeight() const {
    return std::clamp(std::max(options_.takeoff_height_m, mission_.stops[0].height.relative_m), 1.2,
                      1500.0);
  }

  std::string RefPoint() const {
    char text[96];
    std::snprintf(text, sizeof text, "%.8f,%.8f,%.3f", mission_.home.lat_deg, mission_.home.lon_deg,
                  mission_.home.height.ellipsoidal_m.value_or(0));
    return text;
  }

  void AddPlacemark(std::size_t index, bool is_template) {
    const MissionStop& stop = mission_.stops[index];
    char place[64];
    std::snprintf(place, sizeof place, "%.9f,%.9f", stop.lon_deg, stop.lat_deg);
    xml_.Open("Placemark");
    xml_.Open("Point");
    xml_.Leaf("coordinates", place);
    xml_.Close();
    Leaf("index", std::to_string(index));
    if (is_template) {
      AddTemplateHeights(stop);
    } else {
      Leaf("executeHeight",
           Number(is_ellipsoidal_ ? *stop.height.ellipsoidal_m : stop.height.relative_m));
    }
    Leaf("waypointSpeed", Number(options_.speed_m_s));
    xml_.Open("wpml:waypointHeadingParam");
    Leaf("waypointHeadingMode", "smoothTransition");
    Leaf("waypointHeadingAngle", Heading(stop.direction));
    Leaf("waypointHeadingPathMode", "followBadArc");
    xml_.Close();
    xml_.Open("wpml:waypointTurnParam");
    Leaf("waypointTurnMode", "toPointAndStopWithDiscontinuityCurvature");
    Leaf("waypointTurnDampingDist", "0");
    xml_.Close();
    Leaf("useStraightLine", "1");
    if (is_template) Leaf("gimbalPitchAngle", Number(RadToDeg(stop.direction.pitch_rad)));
    if (stop.view_id >= 0) AddPhoto(index, stop);
    xml_.Close();
  }

  // The template's "ellipsoidHeight" is above the ellipsoid, its "height" in its heightMode.
  void AddTemplateHeights(const MissionStop& stop) {
    Leaf("ellipsoidHeight",
         Number(is_ellipsoidal_ ? *stop.height.ellipsoidal_m : stop.height.relative_m));
    Leaf("height", Number(is_ellipsoidal_ ? *stop.height.amsl_m : stop.height.relative_m));
    for (const char* name :
         {"useGlobalHeight", "useGlobalSpeed", "useGlobalHeadingParam", "useGlobalTurnParam"}) {
      Leaf(name, "0");
    }
  }

  void AddPhoto(std::size_t index, const MissionStop& stop) {
    const std::string number = std::to_string(index);
    xml_.Open("wpml:actionGroup");
    Leaf("actionGroupId", std::to_string(actions_++));
    Leaf("actionGroupStartIndex", number);
    Leaf("actionGroupEndIndex", number);
    Leaf("actionGroupMode", "sequence");
    xml_.Open("wpml:actionTrigger");
    Leaf("actionTriggerType", "reachPoint");
    xml_.Close();
    AddGimbal(stop);
    AddHover();
    xml_.Open("wpml:action");
    Leaf("actionId", "2");
    Leaf("actionActuatorFunc", "takePhoto");
    xml_.Open("wpml:actionActuatorFuncParam");
    Leaf("payloadPositionIndex", "0");
    Leaf("fileSuffix", "view_" + std::to_string(stop.view_id));
    Leaf("useGlobalPayloadLensIndex", "1");
    xml_.Close();
    xml_.Close();
    xml_.Close();
  }

  void AddGimbal(const MissionStop& stop) {
    xml_.Open("wpml:action");
    Leaf("actionId", "0");
    Leaf("actionActuatorFunc", "gimbalRotate");
    xml_.Open("wpml:actionActuatorFuncParam");
    Leaf("gimbalHeadingYawBase", "aircraft");
    Leaf("gimbalRotateMode", "absoluteAngle");
    Leaf("gimbalPitchRotateEnable", "1");
    Leaf("gimbalPitchRotateAngle", Number(RadToDeg(stop.direction.pitch_rad)));
    for (const char* name :
         {"gimbalRollRotateEnable", "gimbalRollRotateAngle", "gimbalYawRotateEnable",
          "gimbalYawRotateAngle", "gimbalRotateTimeEnable", "gimbalRotateTime",
          "payloadPositionIndex"}) {
      Leaf(name, "0");
    }
    xml_.Close();
    xml_.Close();
  }

  void AddHover() {
    xml_.Open("wpml:action");
    Leaf("actionId", "1");
    Leaf("actionActuatorFunc", "hover");
    xml_.Open("wpml:actionActuatorFuncParam");
    Leaf("hoverTime", Number(options_.hold_s));
    xml_.Close();
    xml_.Close();
  }

  const Mission& mission_;
  const MissionOptions& options_;
  bool is_ellipsoidal_;
  XmlWriter xml_;
  int actions_ = 0;
};

bool AddToZip(zipFile zip, const char* name, const std::string& text) {
  zip_fileinfo info{};
  info.dosDate = (1u << 21) | (1u << 16);  // 1 January 1980: the same bytes every time
  return zipOpenNewFileInZip(zip, name, &info, nullptr, 0, nullptr, 0, nullptr, Z_DEFLATED,
                             Z_DEFAULT_COMPRESSION) == ZIP_OK &&
         zipWriteInFileInZip(zip, text.data(), static_cast<unsigned>(text.size())) == ZIP_OK &&
         zipCloseFileInZip(zip) == ZIP_OK;
}

}  // namespace

DjiWayline DjiWpml(const Mission& mission, const MissionOptions& options) {
  if (options.height_reference == "amsl") {
    throw Error("DJI: its heights are relative or ellipsoidal, not amsl");
  }
  if (options.height_reference == "ellipsoidal" && !mission.home.height.amsl_m) {
    throw Error(
        "DJI: its template needs heights above sea level beside the ellipsoidal ones: give "
        "--Mission.geoid_undulation_m, install proj-data, or write relative heights");
  }
  if (mission.stops.size() < 2) throw Error("DJI: a wayline needs at least two waypoints");
  return {WpmlWriter(mission, options).Template(), WpmlWriter(mission, options).Waylines()};
}

void WriteDjiKmz(const DjiWayline& wayline, const std::filesystem::path& path) {
  const std::filesystem::path temporary = TemporaryPathFor(path);
  std::error_code ignored;  // that it is not there is seen below
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), ignored);
  const zipFile zip = zipOpen(temporary.c_str(), APPEND_STATUS_CREATE);
  if (zip == nullptr) throw Error(path.string() + ": cannot be written");
  const bool is_written = AddToZip(zip, "wpmz/template.kml", wayline.template_kml) &&
                          AddToZip(zip, "wpmz/waylines.wpml", wayline.waylines_wpml);
  if (zipClose(zip, nullptr) != ZIP_OK || !is_written) {
    std::filesystem::remove(temporary, ignored);
    throw Error(path.string() + ": cannot be written");
  }
  CommitTemporaryFile(temporary, path);
}

}  // namespace colmap_ext
