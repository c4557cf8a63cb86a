// The interactive page of a session: report/index.html, which opens without a server or network.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "colmap_ext/scene/workspace.h"
#include "colmap_ext/util/job_control.h"
#include "colmap_ext/util/options.h"

namespace colmap_ext {

struct PageOptions {
  // Folder with page.html, page.js and page.css; empty: share/colmap_ext/web beside the program's
  // folder, or web/ beside it in a build tree.
  std::filesystem::path assets_path;
  // Photos are shown this wide at most, px, 64 … 8192.
  int photo_width_px = 960;
  // Points of the fused cloud that the page keeps of an iteration, evenly thinned; 0 … 4000000.
  // 0: the page has no fused cloud.
  int max_points = 300000;

  std::string Check() const;
};

void BindOptions(OptionSet& set, PageOptions* options);

// The folder that has the page's assets (see PageOptions); nullopt: it was built without them.
// Throws Error when `assets_path` is given and has none.
std::optional<std::filesystem::path> FindPageAssets(const std::filesystem::path& assets_path);

// Writes the page of a workspace into `folder`: index.html (replaced last, atomically), assets/,
// data/ and photos/ for the interactive page, and pictures.html with pictures/, the page of
// report_page.h, which needs no scripts. Without assets index.html is that page, and a warning says
// so. What has not changed since is not written again. A photo that is missing or damaged is left
// out with a warning. `image_path`: folder of the photos; empty: as state.json says. Throws Error
// when there is no summary.json or a file of an iteration is malformed.
void WriteSessionPage(const Workspace& workspace, const std::filesystem::path& folder,
                      const std::filesystem::path& image_path, const PageOptions& options,
                      const JobControl& job);

}  // namespace colmap_ext
