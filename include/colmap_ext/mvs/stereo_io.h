// Files of superpixel stereo: meshes as PLY, and a dense workspace as COLMAP makes it.
#pragma once

#include <filesystem>
#include <vector>

#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/photo.h"
#include "colmap_ext/scene/reconstruction.h"
#include "colmap_ext/scene/view_mesh.h"
#include "colmap_ext/util/job_rank.h"

namespace colmap_ext {

// The supported triangles of a view with confidence >= min_confidence, in the world, facing the
// camera, each with corners of its own (adjacent triangles may disagree) and its superpixel's
// colour.
ColoredMesh MeshInWorld(const ViewMesh& mesh, double min_confidence);

// The meshes of all views together: the paper's fused mesh, "simply putting together" what agrees.
// PLY with, at each corner, position, normal (unit, facing the camera), colour, `depth` (z in the
// camera frame of its photo, world units) and `confidence` (Γ of its facet).
void WriteFusedMesh(const std::vector<ViewMesh>& views, double min_confidence,
                    const std::filesystem::path& path);

// `<folder>/<photo name>.ply` for each view, the same properties. `views` has one entry a photo, in
// order. Of several processes each writes its own photos'.
void WriteViewMeshes(const PhotoSet& photos, const std::vector<ViewMesh>& views,
                     double min_confidence, const std::filesystem::path& folder,
                     const JobRank& rank = {});

// A folder that `colmap stereo_fusion --workspace_path <folder> --input_type geometric` takes:
// images/, sparse/ (the model with pinhole cameras of the photos' sizes), stereo/depth_maps and
// stereo/normal_maps (<name>.geometric.bin), stereo/confidence_maps (<name>.bin), stereo/fusion.cfg
// and stereo/patch-match.cfg (each view's neighbours). Depths of supported triangles with
// confidence >= min_confidence. `model` is the model that `photos` was loaded from; photos must
// have pixels. Of several processes each writes its own photos, and the first one the rest. Throws
// Error naming the photo that `model` does not have.
void WriteDenseWorkspace(const PhotoSet& photos, const Reconstruction& model,
                         const std::vector<ViewMesh>& views,
                         const std::vector<std::vector<int>>& neighbors, double min_confidence,
                         const std::filesystem::path& folder, const JobRank& rank = {});

}  // namespace colmap_ext
