// Where things are in a workspace (docs/file_formats.md).
#pragma once

#include <filesystem>
#include <optional>

namespace colmap_ext {

class Workspace {
 public:
  explicit Workspace(std::filesystem::path root) : root_(std::move(root)) {}

  const std::filesystem::path& root() const { return root_; }
  std::filesystem::path session_ini() const { return root_ / "session.ini"; }
  std::filesystem::path state_json() const { return root_ / "state.json"; }
  std::filesystem::path summary_json() const { return root_ / "summary.json"; }
  std::filesystem::path database() const { return root_ / "database.db"; }
  // Names of the photos that the pilot vouches for: see FirstFlightPhotos (image_list.h).
  std::filesystem::path first_flight_txt() const { return root_ / "first_flight.txt"; }
  std::filesystem::path images() const { return root_ / "images"; }
  std::filesystem::path images_full() const { return root_ / "images_full"; }
  std::filesystem::path report() const { return root_ / "report"; }
  std::filesystem::path logs() const { return root_ / "logs"; }

  // Folder of iteration `index` (0, 1, …): iterations/000, iterations/001, …
  std::filesystem::path iteration(int index) const;
  // Highest iteration that has a sparse model; nullopt when there is none.
  std::optional<int> LatestIteration() const;

 private:
  std::filesystem::path root_;
};

// Files of one iteration, relative to Workspace::iteration(i).
struct IterationFiles {
  std::filesystem::path folder;
  std::filesystem::path sparse() const { return folder / "sparse"; }
  // What stereo keeps of the photos that this iteration solved.
  std::filesystem::path stereo_bin() const { return folder / "stereo.bin"; }
  std::filesystem::path meshes() const { return folder / "meshes"; }
  std::filesystem::path dense() const { return folder / "dense"; }
  std::filesystem::path pictures() const { return folder / "pictures"; }
  std::filesystem::path fused_ply() const { return folder / "fused.ply"; }
  std::filesystem::path surface_ply() const { return folder / "surface.ply"; }
  std::filesystem::path coverage_ply() const { return folder / "coverage.ply"; }
  std::filesystem::path coverage_json() const { return folder / "coverage.json"; }
  std::filesystem::path views_json() const { return folder / "views.json"; }
  std::filesystem::path path_json() const { return folder / "path.json"; }
  std::filesystem::path mission_plan() const { return folder / "mission.plan"; }
  std::filesystem::path sparse_state_json() const { return folder / "sparse_state.json"; }
  std::filesystem::path timing_json() const { return folder / "timing.json"; }
  // The frame of the model: {"metric": bool, "origin": {lat, lon, height}} (see world_frame.h).
  std::filesystem::path frame_json() const { return folder / "frame.json"; }
};

}  // namespace colmap_ext
