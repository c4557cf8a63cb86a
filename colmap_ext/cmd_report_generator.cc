#include <iostream>

#include "colmap_ext/report/report_page.h"
#include "colmap_ext/report/session_page.h"
#include "colmap_ext/report/summary_table.h"
#include "colmap_ext/util/files.h"
#include "command_line.h"
#include "commands.h"

namespace colmap_ext {

int RunReportGenerator(const Arguments& arguments, Program& program) {
  std::filesystem::path workspace_path, output_path, image_path;
  PageOptions options;
  CommandLine line("report_generator",
                   "Writes the page of a session, report/index.html, anew from the files in its "
                   "workspace, and prints its table.");
  line.options().Add("", "workspace_path", &workspace_path, "the session's workspace");
  line.options().Add("", "output_path", &output_path,
                     "folder of the page; empty: report/ in the workspace");
  line.options().Add("", "image_path", &image_path,
                     "folder of the photos; empty: where the session says that they are");
  BindOptions(line.options(), &options);
  if (!line.Parse(arguments, &program.log)) return 0;
  RequireOption(workspace_path, "workspace_path");
  const JobControl job = program.Job();

  const Workspace workspace(workspace_path);
  const SessionSummary summary = ReadReportInput(workspace).summary;
  const std::filesystem::path folder = output_path.empty() ? workspace.report() : output_path;
  RequireWritableFolder(folder, "folder of the page");
  WriteSessionPage(workspace, folder, image_path, options, job);
  std::cout << SummaryTable(summary);
  job.Info("wrote " + (folder / "index.html").string());
  program.log.Result({{"iterations", summary.iterations.size()},
                      {"output_path", (folder / "index.html").string()}});
  return 0;
}

}  // namespace colmap_ext
