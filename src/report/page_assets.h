// Style and script of the page, kept in the page itself so that it opens from a folder, offline.
#pragma once

namespace colmap_ext {

extern const char* const kPageStyle;
extern const char* const kPageScript;

}  // namespace colmap_ext
