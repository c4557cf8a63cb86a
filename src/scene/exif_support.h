// Exiv2 behind a small border: opening, locking, and numbers.
#pragma once

#include <cstdint>
#include <exiv2/exiv2.hpp>
#include <optional>
#include <string>

namespace colmap_ext {

// Makes Exiv2 safe to use from many threads (its XMP parser keeps global state) and quiet. Cheap
// after the first call; every use of Exiv2 calls it first.
void PrepareExiv2();

// Component `index` of a tag as a number; nullopt when it is not there, 0/0 or x/0.
std::optional<double> ExifNumber(const Exiv2::ExifData& exif, const char* key, long index = 0);
// Text of a tag without surrounding blanks; empty when it is not there.
std::string ExifText(const Exiv2::ExifData& exif, const char* key);
// Number of an XMP property such as "+162.10"; nullopt when it is not there or no number.
std::optional<double> XmpNumber(const Exiv2::XmpData& xmp, const std::string& key);

// Sets a tag from Exiv2's text form ("33/1 37/1 393314/10000").
void SetExif(Exiv2::ExifData* exif, const char* key, Exiv2::TypeId type, const std::string& value);
// "n/d" for value with denominator d. Throws Error when n does not fit 32 bits.
std::string ExifRational(double value, std::int64_t denominator, const char* what);

}  // namespace colmap_ext
