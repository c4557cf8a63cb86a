#include "colmap_ext/util/exit_code.h"

#include <iostream>
#include <new>
#include <system_error>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/job_control.h"

namespace colmap_ext {

int ExitCodeOf(const std::function<int()>& run, const FailureReport& report) {
  try {
    return run();
  } catch (const UsageError& error) {
    report("usage", error.what());
    return 2;
  } catch (const CancelledError& error) {
    report("stopped", error.what());
  } catch (const std::bad_alloc&) {
    report("memory", "not enough memory");
  } catch (const std::system_error& error) {
    // What a thread says that cannot be started.
    const bool is_thread = error.code() == std::errc::resource_unavailable_try_again;
    report(is_thread ? "memory" : "failed",
           is_thread ? "not enough memory, or threads, to start a thread" : error.what());
  } catch (const std::exception& error) {
    report("failed", error.what());
  }
  return 1;
}

int ExitCodeOf(const std::string& program, const std::function<int()>& run) {
  return ExitCodeOf(run, [&](const char*, const std::string& what) {
    std::cerr << program << ": " << what << '\n';
  });
}

}  // namespace colmap_ext
