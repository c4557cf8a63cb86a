// The page of a session as pictures and tables: one file and the pictures beside it, no scripts
// needed. The interactive one: session_page.h.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/report/summary.h"
#include "colmap_ext/scene/workspace.h"

namespace colmap_ext {

struct ReportPicture {
  std::string title;           // shown below it
  std::filesystem::path file;  // PNG or JPEG; copied into the report
};

struct ReportInput {
  std::string title;  // of the page, for example the workspace's name
  SessionSummary summary;
  // Pictures of each iteration, in the order in which they are shown; as many entries as
  // summary.iterations (an entry may be empty).
  std::vector<std::vector<ReportPicture>> pictures;
};

// Writes the page (folder/index.html unless `page_name` says otherwise) and folder/pictures/. The
// page needs nothing else: no network, no server. The page is replaced atomically after its
// pictures are there; pictures that have not changed are not copied again. Throws Error naming a
// picture that is missing, or the file that cannot be written.
void WriteReportPage(const ReportInput& input, const std::filesystem::path& folder,
                     const std::string& page_name = "index.html");

// The page's input from what a workspace holds: summary.json, iterations/NNN/pictures/*.png, and
// timing.json where the summary lacks the seconds of the stages. Pictures named superpixels,
// confidence, surface, coverage and path come first, in this order and under their full titles;
// others follow by name. Throws Error when there is no summary.json or a file is malformed.
ReportInput ReadReportInput(const Workspace& workspace);

// Names, below iterations/NNN/pictures/, of the pictures that the page knows, in its order.
std::vector<std::string> ReportPictureNames();

}  // namespace colmap_ext
