#include "colmap_ext/dense/texture.h"

#include "dense/openmvs_programs.h"

namespace colmap_ext {

namespace fs = std::filesystem;

std::string WhyNoTexture() { return WhyNoOpenMvs({kInterfaceColmap, kTextureMesh}); }

void TextureSurface(const DenseWorkspace& workspace, const fs::path& mesh_path,
                    const fs::path& obj_path, const JobControl& job) {
  const fs::path scene = ImportIntoOpenMvs(workspace, job);
  // The programs run in a folder of their own: paths must hold there, too.
  RunOpenMvs(kTextureMesh,
             {"-i", scene.string(), "-m", fs::absolute(mesh_path).string(), "-o",
              fs::absolute(obj_path).string(), "--export-type", "obj"},
             obj_path, workspace, job);
}

}  // namespace colmap_ext
