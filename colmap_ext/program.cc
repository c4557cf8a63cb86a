#include "program.h"

#include <exception>
#include <new>

#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

int RunGuarded(const std::function<int()>& body, ProgramLog* log) {
  try {
    return body();
  } catch (const UsageError& error) {
    log->Fail("usage", error.what());
    return 2;
  } catch (const CancelledError& error) {
    log->Fail("stopped", error.what());
  } catch (const std::bad_alloc&) {
    log->Fail("memory", "not enough memory");
  } catch (const std::exception& error) {
    log->Fail("failed", error.what());
  }
  return 1;
}

}  // namespace

int Program::Run(const std::vector<std::string>& arguments, const std::function<int()>& body) {
  log.Start(COLMAP_EXT_VERSION, arguments);
  const int exit_code = RunGuarded(body, &log);
  log.End(exit_code);
  return exit_code;
}

}  // namespace colmap_ext
