// Whether the bytes of a picture are all there. OpenCV's decoders fill what is missing with grey
// and say nothing.
#pragma once

#include <string>
#include <string_view>

namespace colmap_ext {

// What is wrong with the structure of a JPEG, PNG or TIFF file, in words for the user; empty when
// its frame is complete. Decoded pixels are not looked at.
std::string FindPictureDefect(std::string_view bytes);

}  // namespace colmap_ext
