#include "fuzz/targets.h"

#include <stdexcept>

namespace colmap_ext {
namespace {

constexpr int kOfFiles = 10000;  // writing and reading a file takes longer than parsing it

}  // namespace

void Promise(bool holds, const char* what) {
  if (!holds) throw std::logic_error(what);
}

std::vector<FuzzTarget> AllFuzzTargets() {
  return {{"mav_parser", FuzzMavParser},
          {"mav_ftp_server", FuzzMavFtpServer},
          {"mav_ftp_client", FuzzMavFtpClient},
          {"mav_urls", FuzzMavUrls},
          {"colmap_binary", FuzzColmapBinary, kOfFiles},
          {"colmap_text", FuzzColmapText, kOfFiles},
          {"dense_map", FuzzDenseMap, kOfFiles},
          {"stereo_memory", FuzzStereoMemory, kOfFiles},
          {"ply", FuzzPly, kOfFiles},
          {"obj", FuzzObj, kOfFiles},
          {"las", FuzzLas, kOfFiles},
          {"exif", FuzzExif, kOfFiles},
          {"geojson", FuzzGeoJson, kOfFiles},
          {"positions", FuzzPositions, kOfFiles},
          {"ini", FuzzIni, kOfFiles},
          {"workspace_json", FuzzWorkspaceJson, kOfFiles},
          {"capture_journal", FuzzCaptureJournal, kOfFiles},
          {"flight_journal", FuzzFlightJournal},
          {"daemon_api", FuzzDaemonApi},
          {"page_requests", FuzzPageRequests}};
}

}  // namespace colmap_ext
