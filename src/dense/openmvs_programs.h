#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/dense/dense_workspace.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

inline constexpr const char* kInterfaceColmap = "InterfaceCOLMAP";
inline constexpr const char* kDensifyPointCloud = "DensifyPointCloud";
inline constexpr const char* kTextureMesh = "TextureMesh";

// The first of `programs` that is not on the PATH, as a sentence; "" when all are.
std::string WhyNoOpenMvs(const std::vector<std::string>& programs);

// Where OpenMVS keeps its own files for a workspace: absolute, as all paths given to its programs
// must be, for they take others relative to this folder.
std::filesystem::path OpenMvsFolder(const DenseWorkspace& workspace);

// Runs `program` in OpenMvsFolder(), its output in the workspace's logs. Throws Error when it
// fails or does not make `result` (an older file of that name is removed first); CancelledError.
void RunOpenMvs(const std::string& program, const std::vector<std::string>& arguments,
                const std::filesystem::path& result, const DenseWorkspace& workspace,
                const JobControl& job);

// The workspace's photos and sparse model as OpenMVS' scene, whose path is returned.
std::filesystem::path ImportIntoOpenMvs(const DenseWorkspace& workspace, const JobControl& job);

}  // namespace colmap_ext
