// Offline dense reconstruction behind one interface.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "colmap_ext/dense/options.h"
#include "colmap_ext/dense/photo_source.h"
#include "colmap_ext/geom/mesh.h"
#include "colmap_ext/scene/oriented_points.h"
#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/job_rank.h"

namespace colmap_ext {

struct DenseRequest {
  const PhotoSource* photos = nullptr;  // required, not owned
  // Folder for everything that a back end keeps: images/, sparse/ and stereo/ as COLMAP's
  // image_undistorter makes them, logs/, and what is needed to go on after a stop.
  std::filesystem::path workspace_path;
  // A dense workspace of the same photos (superpixel_stereo's dense/): its depth maps, of any size,
  // say how deep each photo looks. Empty: the sparse points do.
  std::filesystem::path prior_path;
  // Points outside are left out of the cloud; empty box: all are kept.
  BoundingBox region;
  // The built-in one only: this process's share of the work. All processes see workspace_path.
  JobRank rank;
};

class DenseBackEnd {
 public:
  virtual ~DenseBackEnd() = default;
  virtual std::string Name() const = 0;
  // Why it cannot be used here and what to do about it; "" when it can.
  virtual std::string WhyUnavailable() const = 0;
  // The fused cloud, world frame. Goes on with what an earlier call with the same input left in the
  // workspace. Throws Error when a step fails or gives an empty or absurd result, whatever its exit
  // code; CancelledError.
  virtual OrientedPoints Reconstruct(const DenseRequest& request, const JobControl& job) = 0;
};

// How the `colmap` program is run: given by the caller, for its dialects belong to `sfm`.
struct ColmapTool {
  using Arguments = std::vector<std::pair<std::string, std::string>>;  // without "--"
  // Runs `colmap <command>`, output appended to `log_path`; throws Error when it fails. Empty:
  // there is no colmap.
  std::function<void(const std::string& command, const Arguments& arguments,
                     const std::filesystem::path& log_path, const JobControl& job)>
      run;
  std::string help;  // what `colmap help` prints
};

// patch_match_stereo and stereo_fusion; needs a colmap with CUDA.
std::unique_ptr<DenseBackEnd> MakeColmapBackEnd(ColmapTool tool);
// InterfaceCOLMAP and DensifyPointCloud on the PATH.
std::unique_ptr<DenseBackEnd> MakeOpenMvsBackEnd();
// This program's own, on the CPU (builtin.h).
std::unique_ptr<DenseBackEnd> MakeBuiltinBackEnd(const DenseStereoOptions& options);

// The back end called `name`, or with "auto" the first usable one in the order given. Throws
// UsageError for an unknown name, Error saying why when it cannot be used.
DenseBackEnd& ChooseBackEnd(const std::string& name,
                            const std::vector<std::unique_ptr<DenseBackEnd>>& back_ends);

// Throws Error naming `producer` when `points` are fewer than 100, not finite, or lie, more than
// half of them, behind or outside every photo (seen with a margin of 5 %).
void CheckCloud(const OrientedPoints& points, const PhotoSet& photos, const std::string& producer);

}  // namespace colmap_ext
