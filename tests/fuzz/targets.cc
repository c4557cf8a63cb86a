#include "fuzz/targets.h"

#include <stdexcept>

namespace colmap_ext {

void Promise(bool holds, const char* what) {
  if (!holds) throw std::logic_error(what);
}

std::vector<FuzzTarget> AllFuzzTargets() {
  return {{"mav_parser", FuzzMavParser},
          {"mav_ftp_server", FuzzMavFtpServer},
          {"mav_ftp_client", FuzzMavFtpClient},
          {"mav_urls", FuzzMavUrls}};
}

}  // namespace colmap_ext
