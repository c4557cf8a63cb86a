#include "session/session_state.h"

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/scene/region_json.h"

namespace colmap_ext {
namespace {

constexpr int kVersion = 1;

}  // namespace

SessionState ReadSessionState(const std::filesystem::path& path) {
  const Json json = ReadJsonFile(path);
  const JsonNode root(json, path);
  if (root["version"].Integer() != kVersion) {
    root["version"].Fail("is not a version that this program knows; use a new workspace");
  }
  SessionState state;
  state.source = root["source"].Text();
  state.iterations_done = root["iterations_done"].Integer();
  state.next_view_id = root["next_view_id"].Integer();
  state.finished = root["finished"].Text();
  if (const auto region = root.Find("region")) {
    state.region = RegionFromJson(*region);
  }
  if (const auto gsd = root.Find("site_gsd_mm")) state.site_gsd_mm = gsd->Number();
  if (state.iterations_done < 0) root["iterations_done"].Fail("must not be negative");
  return state;
}

void WriteSessionState(const SessionState& state, const std::filesystem::path& path) {
  Json json = {{"version", kVersion},
               {"source", state.source},
               {"iterations_done", state.iterations_done},
               {"next_view_id", state.next_view_id},
               {"finished", state.finished}};
  if (state.region) json["region"] = RegionToJson(*state.region);
  if (state.site_gsd_mm) json["site_gsd_mm"] = *state.site_gsd_mm;
  WriteJsonFile(json, path);
}

}  // namespace colmap_ext
