// The pictures of a simulated drone: rendered in a worker, kept as files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/sim/autopilot.h"
#include "colmap_ext/sim/simulated_camera.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

enum class PictureState { kUnknown, kPending, kReady, kFailed };

struct PictureEntry {
  int index = 0;
  std::uint32_t time_boot_ms = 0;
  std::string name;  // "img_00007.jpg"
  PictureState low = PictureState::kPending, full = PictureState::kPending;
};

// Writes <folder>/low/<name>, <folder>/full/<name> (after all low ones that wait), and keeps
// <folder>/true_poses.txt and <folder>/captures.jsonl up to date: before a low picture is ready,
// its lines are there. Methods may be called from any thread.
class PictureStore {
 public:
  // Called in the worker when a picture is ready or has failed.
  using Done = std::function<void(const std::string& name, PhotoResolution resolution)>;

  // `camera` must outlive it. Without `renders_full` there are no full pictures. Throws Error when
  // the folder cannot be written to, or holds pictures of an earlier flight.
  PictureStore(const SimulatedCamera& camera, std::filesystem::path folder, bool renders_full,
               Done done, const JobControl& job);
  ~PictureStore();  // after the picture at hand; what waits is dropped

  void Add(const ShutterEvent& event);  // returns at once

  std::vector<PictureEntry> List() const;  // in the order of Add()
  PictureState StateOf(const std::string& name, PhotoResolution resolution) const;
  std::filesystem::path PathOf(const std::string& name, PhotoResolution resolution) const;
  int NumWaiting() const;  // low pictures that are not rendered yet

  static std::string NameOf(int index);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colmap_ext
