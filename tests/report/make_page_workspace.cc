// make_page_workspace <folder>: the workspace that the tests in a browser open, with its page.
// make_page_workspace <folder> --serve: the same, then serves it: prints the address, shows the
// first iteration as all there is, and takes words from standard input: "next" finishes one more
// iteration, "finish" ends the session. Ends with the input.
#include <iostream>

#include "colmap_ext/report/page_server.h"
#include "colmap_ext/report/summary_json.h"
#include "report/made_up_workspace.h"

namespace {

using namespace colmap_ext;

constexpr int kIterations = 3;

void WriteFirst(const Workspace& workspace, const SessionSummary& all, std::size_t count) {
  SessionSummary summary = all;
  summary.iterations.resize(count);
  summary.finished = count == all.iterations.size() ? all.finished : "";
  WriteSummary(summary, workspace.summary_json());
  WriteSessionPage(workspace, workspace.report(), {}, {}, {});
}

void Serve(const Workspace& workspace) {
  const SessionSummary all = ReadSummary(workspace.summary_json());
  std::size_t count = 1;
  WriteFirst(workspace, all, count);
  PageServer server(workspace, {}, 0, nullptr);
  server.Message(LogLevel::kInfo, "Iteration 1");
  server.Progress("matching", 3, 12);
  std::cout << server.url() << std::endl;
  for (std::string word; std::cin >> word;) {
    if (word == "next") WriteFirst(workspace, all, ++count);
    if (word == "finish") server.Finish();
    server.Message(LogLevel::kWarning, "did: " + word);
    std::cout << "done" << std::endl;
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: make_page_workspace <folder> [--serve]\n";
    return 2;
  }
  std::filesystem::remove_all(argv[1]);
  MakeWorkspace(argv[1], kIterations);
  const Workspace workspace{argv[1]};
  if (argc > 2) {
    Serve(workspace);
  } else {
    WriteSessionPage(workspace, workspace.report(), {}, {}, {});
  }
  return 0;
}
