#include "session/flight_recovery.h"

#include <sstream>
#include <vector>

#include "colmap_ext/flight/flight_journal.h"
#include "colmap_ext/scene/true_poses.h"
#include "colmap_ext/sim/picture_store.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "session/simulated_site.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// Whether the line tells of a photo that is not there: it will be taken again.
bool IsOfMissingPhoto(const std::string& line, const fs::path& images) {
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object() || !json.contains("file") || !json["file"].is_string()) return false;
  return !fs::exists(images / json["file"].get<std::string>());
}

void PruneCaptures(const Workspace& workspace) {
  const fs::path path = workspace.images() / "captures.jsonl";
  if (!fs::exists(path)) return;
  std::istringstream lines(ReadFile(path));
  std::string kept;
  for (std::string line; std::getline(lines, line);) {
    if (!lines.eof() && !IsOfMissingPhoto(line, workspace.images())) kept += line + "\n";
  }
  WriteFileAtomically(path, kept);
}

// A file is on disk before the record of it.
void NoteStoredFiles(const Workspace& workspace, FlightJournal* journal) {
  std::vector<Json> records;
  for (const auto& [view_id, entry] : journal->ledger().views) {
    const bool is_unknown =
        entry.status == ViewStatus::kCaptured && fs::exists(workspace.images() / entry.photo);
    if (!is_unknown) continue;
    records.push_back({{"type", "stored"},
                       {"view", view_id},
                       {"resolution", "low"},
                       {"file", entry.photo},
                       {"sha256", ""}});
  }
  records.push_back({{"type", "new_camera"}});
  journal->Append(records);
}

void TakeFullPhotos(const std::map<std::string, int>& index_of_photo, const Workspace& workspace,
                    const JobControl& job) {
  for (const auto& [photo, index] : index_of_photo) {
    const fs::path target = workspace.images_full() / photo;
    if (fs::exists(target)) continue;
    const fs::path source = DronePath(workspace) / "full" / PictureStore::NameOf(index);
    if (fs::exists(source)) {
      WriteFileAtomically(target, ReadFile(source));
    } else {
      job.Warn(photo + ": its full resolution is lost with the drone that took it");
    }
  }
}

}  // namespace

fs::path DronePath(const Workspace& workspace) { return workspace.root() / "drone"; }

void TakeTruePoses(const std::map<std::string, int>& index_of_photo, const Workspace& workspace) {
  const fs::path path = DronePath(workspace) / "true_poses.txt";
  if (!fs::exists(path)) return;
  const auto true_pose = PoseOfPhoto(ReadTruePoses(path));
  std::vector<TruePose> poses;
  for (const auto& [photo, index] : index_of_photo) {
    const auto pose = true_pose.find(PictureStore::NameOf(index));
    if (pose != true_pose.end()) poses.push_back({photo, pose->second});
  }
  UpdateTruePoses(poses, SimulatedSite::TruePosesPath(workspace));
}

void RecoverFromLastDrone(const Workspace& workspace, bool full_resolution, const JobControl& job) {
  const fs::path journal_path = workspace.root() / "flight" / "journal.jsonl";
  if (fs::exists(journal_path)) {
    FlightJournal journal(journal_path);
    std::map<std::string, int> index_of_photo;  // of this drone only: see new_camera
    for (const auto& [view_id, entry] : journal.ledger().views) {
      const bool has_picture =
          entry.status == ViewStatus::kCaptured || entry.status == ViewStatus::kStored;
      const bool is_there = has_picture && entry.capture.record.index >= 0 &&
                            fs::exists(workspace.images() / entry.photo);
      if (is_there) index_of_photo[entry.photo] = entry.capture.record.index;
    }
    TakeTruePoses(index_of_photo, workspace);
    if (full_resolution) TakeFullPhotos(index_of_photo, workspace, job);
    NoteStoredFiles(workspace, &journal);
    PruneCaptures(workspace);
  }
  std::error_code error;
  fs::remove_all(DronePath(workspace), error);
  if (error) throw Error(DronePath(workspace).string() + ": cannot be removed: " + error.message());
}

}  // namespace colmap_ext
