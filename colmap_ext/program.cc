#include "program.h"

#include "colmap_ext/util/exit_code.h"

namespace colmap_ext {
int Program::Run(const std::vector<std::string>& arguments, const std::function<int()>& body) {
  log.Start(COLMAP_EXT_VERSION, arguments);
  const int exit_code =
      ExitCodeOf(body, [&](const char* kind, const std::string& what) { log.Fail(kind, what); });
  log.End(exit_code);
  return exit_code;
}

}  // namespace colmap_ext
