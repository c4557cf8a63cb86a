#include "colmap_ext/scene/reconstruction_io.h"

#include <cmath>

#include "colmap_ext/util/error.h"
#include "scene/reconstruction_files.h"

namespace colmap_ext {

Eigen::Quaterniond RotationFromFile(double w, double x, double y, double z) {
  const Eigen::Quaterniond q(w, x, y, z);
  const double norm = q.norm();
  // Dividing a unit quaternion by a norm of 1 ± 1 bit would change it at every round trip.
  if (std::abs(norm - 1) < 1e-14) return q;
  return Eigen::Quaterniond(q.coeffs() / norm);
}

void RequireNoForeignFrames(const Reconstruction& model, const std::filesystem::path& folder) {
  if (!model.frame_table.IsEmpty()) return;
  for (const char* name : {"rigs.bin", "frames.bin", "rigs.txt", "frames.txt"}) {
    if (std::filesystem::exists(folder / name)) {
      throw Error((folder / name).string() +
                  ": belongs to another model; write this one to a new folder");
    }
  }
}

Reconstruction ReadReconstruction(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder)) {
    throw Error(folder.string() + ": no such folder; give the folder of a sparse model");
  }
  const bool is_binary = std::filesystem::exists(folder / "cameras.bin");
  if (!is_binary && !std::filesystem::exists(folder / "cameras.txt")) {
    throw Error(folder.string() +
                ": holds no sparse model (neither cameras.bin nor cameras.txt); give the folder "
                "that `colmap mapper` wrote, for example sparse/0");
  }
  Reconstruction reconstruction = is_binary ? ReadBinaryModel(folder) : ReadTextModel(folder);
  CheckConsistency(reconstruction, folder.string());
  if (is_binary) {
    ReadBinaryFrameTable(folder, &reconstruction);
  } else {
    ReadTextFrameTable(folder, &reconstruction);
  }
  return reconstruction;
}

}  // namespace colmap_ext
