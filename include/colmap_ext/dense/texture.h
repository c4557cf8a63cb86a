// A texture for a finished mesh, by OpenMVS' programs where they are on the PATH.
#pragma once

#include <filesystem>
#include <string>

#include "colmap_ext/dense/dense_workspace.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

// Why no texture can be made here; "" when it can (InterfaceCOLMAP and TextureMesh).
std::string WhyNoTexture();

// Textures the PLY mesh at `mesh_path`, in the frame of the workspace's sparse model, from the
// workspace's photos: `obj_path` with its material and pictures beside it. Throws Error when a
// program fails or writes nothing, whatever its exit code; CancelledError.
void TextureSurface(const DenseWorkspace& workspace, const std::filesystem::path& mesh_path,
                    const std::filesystem::path& obj_path, const JobControl& job);

}  // namespace colmap_ext
