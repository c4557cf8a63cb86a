#include "scene/exif_support.h"

#include <cmath>
#include <mutex>

#include "colmap_ext/util/error.h"
#include "scene/text_numbers.h"

namespace colmap_ext {
namespace {

void LockXmp(void* mutex, bool lock) {
  if (lock) {
    static_cast<std::recursive_mutex*>(mutex)->lock();
  } else {
    static_cast<std::recursive_mutex*>(mutex)->unlock();
  }
}

}  // namespace

void PrepareExiv2() {
  // Exiv2's XMP toolkit is a global of that library; its lock has to live as long as the process.
  static std::recursive_mutex xmp_mutex;
  static std::once_flag once;
  std::call_once(once, [] {
    Exiv2::XmpParser::initialize(&LockXmp, &xmp_mutex);
    Exiv2::LogMsg::setLevel(Exiv2::LogMsg::mute);
  });
}

std::optional<double> ExifNumber(const Exiv2::ExifData& exif, const char* key, long index) {
  const auto it = exif.findKey(Exiv2::ExifKey(key));
  if (it == exif.end() || static_cast<long>(it->count()) <= index) return std::nullopt;
  // Integers come as n/1; 0xFFFFFFFF as numerator or denominator stands for "unknown".
  const Exiv2::TypeId type = it->typeId();
  if (type == Exiv2::unsignedRational) {
    const auto& values = dynamic_cast<const Exiv2::URationalValue&>(it->value()).value_;
    const auto [numerator, denominator] = values.at(static_cast<std::size_t>(index));
    if (denominator == 0 || numerator == 0xFFFFFFFF || denominator == 0xFFFFFFFF)
      return std::nullopt;
    return static_cast<double>(numerator) / denominator;
  }
  if (type == Exiv2::signedRational) {
    const auto& values = dynamic_cast<const Exiv2::RationalValue&>(it->value()).value_;
    const auto [numerator, denominator] = values.at(static_cast<std::size_t>(index));
    if (denominator == 0 || denominator == -1) return std::nullopt;
    return static_cast<double>(numerator) / denominator;
  }
  return ParseNumber(it->toString(index));
}

std::string ExifText(const Exiv2::ExifData& exif, const char* key) {
  const auto it = exif.findKey(Exiv2::ExifKey(key));
  if (it == exif.end()) return "";
  const std::string text = it->toString();
  const std::string blanks(" \t\r\n\0", 5);
  const auto begin = text.find_first_not_of(blanks);
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(blanks) - begin + 1);
}

std::optional<double> XmpNumber(const Exiv2::XmpData& xmp, const std::string& key) {
  // XmpKey would throw for a prefix (DJI's) that no file has declared so far: compare names
  // instead.
  for (const auto& datum : xmp) {
    if (datum.key() == key) return ParseNumber(datum.toString());
  }
  return std::nullopt;
}

void SetExif(Exiv2::ExifData* exif, const char* key, Exiv2::TypeId type, const std::string& value) {
  const auto parsed = Exiv2::Value::create(type);
  if (parsed->read(value) != 0) {
    throw Error(std::string(key) + " cannot be set to '" + value + "'");
  }
  (*exif)[key].setValue(parsed.get());
}

std::string ExifRational(double value, std::int64_t denominator, const char* what) {
  const double numerator = std::round(value * static_cast<double>(denominator));
  if (!(numerator >= 0 && numerator < 4294967295.0)) {
    throw Error(std::string(what) + " = " + std::to_string(value) +
                " does not fit an EXIF rational");
  }
  return std::to_string(static_cast<std::int64_t>(numerator)) + "/" + std::to_string(denominator);
}

}  // namespace colmap_ext
