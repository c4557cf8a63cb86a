#pragma once

#include <string>

namespace colmap_ext {

// Text as it may stand between tags or in a quoted attribute.
std::string EscapeHtml(const std::string& text);

// A relative path as a URL: everything but letters, digits and - _ . ~ / is percent-encoded.
std::string EncodeUrlPath(const std::string& path);

}  // namespace colmap_ext
