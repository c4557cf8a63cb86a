#include "colmap_ext/scene/photo_metadata.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exiv2/exiv2.hpp>

#include "colmap_ext/geom/transforms.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "scene/exif_support.h"
#include "scene/parallel.h"

namespace colmap_ext {
namespace {

constexpr double kFilmWidthMm = 36.0;

struct KnownSensor {
  const char* camera_model;  // as EXIF names it
  double width_mm;
};

// The 35 mm equivalent of a drone's camera is rounded and its convention (width or diagonal) is
// anybody's guess: for the DJI Mini 2 it is 12 % off, this table 4 %. Widths from the makers'
// sensor formats (1/2.3", 1/2", 1").
constexpr std::array<KnownSensor, 9> kKnownSensors = {{{"FC7303", 6.16},   // DJI Mini 2
                                                       {"FC7203", 6.17},   // DJI Mavic Mini
                                                       {"FC220", 6.17},    // DJI Mavic Pro
                                                       {"FC330", 6.17},    // DJI Phantom 4
                                                       {"FC3170", 6.4},    // DJI Mavic Air 2
                                                       {"FC6310", 13.2},   // DJI Phantom 4 Pro
                                                       {"FC6310R", 13.2},  // DJI Phantom 4 RTK
                                                       {"L1D-20c", 13.2},  // DJI Mavic 2 Pro
                                                       {kSimulatedModel, kFilmWidthMm}}};

// Degrees, minutes and seconds; later ones may be missing.
std::optional<double> ExifDegrees(const Exiv2::ExifData& exif, const char* key) {
  const auto degrees = ExifNumber(exif, key, 0);
  if (!degrees) return std::nullopt;
  return *degrees + ExifNumber(exif, key, 1).value_or(0) / 60 +
         ExifNumber(exif, key, 2).value_or(0) / 3600;
}

std::optional<GeoPosition> GpsFromExif(const Exiv2::ExifData& exif) {
  const auto lat = ExifDegrees(exif, "Exif.GPSInfo.GPSLatitude");
  const auto lon = ExifDegrees(exif, "Exif.GPSInfo.GPSLongitude");
  const auto height = ExifNumber(exif, "Exif.GPSInfo.GPSAltitude");
  if (!lat || !lon || !height) return std::nullopt;
  if (ExifText(exif, "Exif.GPSInfo.GPSStatus") == "V") return std::nullopt;  // void: no fix
  if (*lat == 0 && *lon == 0) return std::nullopt;  // what cameras write before they have a fix
  GeoPosition position{.lat_deg = *lat, .lon_deg = *lon, .height_m = *height};
  if (ExifText(exif, "Exif.GPSInfo.GPSLatitudeRef") == "S") position.lat_deg = -position.lat_deg;
  if (ExifText(exif, "Exif.GPSInfo.GPSLongitudeRef") == "W") position.lon_deg = -position.lon_deg;
  if (ExifNumber(exif, "Exif.GPSInfo.GPSAltitudeRef").value_or(0) == 1) {  // below sea level
    position.height_m = -position.height_m;
  }
  if (!IsValid(position)) return std::nullopt;
  return position;
}

std::optional<double> FocalFromExif(const Exiv2::ExifData& exif, const PhotoMetadata& metadata) {
  const double long_side_px = std::max(metadata.width, metadata.height);
  const auto focal_mm = ExifNumber(exif, "Exif.Photo.FocalLength");
  const auto sensor_mm = SensorWidthMm(metadata.camera_model);
  if (focal_mm && *focal_mm > 0 && sensor_mm) return *focal_mm / *sensor_mm * long_side_px;
  const auto focal_35mm = ExifNumber(exif, "Exif.Photo.FocalLengthIn35mmFilm");
  if (focal_35mm && *focal_35mm > 0) return *focal_35mm / kFilmWidthMm * long_side_px;
  return std::nullopt;
}

void ReadDirection(const Exiv2::ExifData& exif, const Exiv2::XmpData& xmp,
                   PhotoMetadata* metadata) {
  const auto heading_deg = ExifNumber(exif, "Exif.GPSInfo.GPSImgDirection");
  // Magnetic headings need a declination that we do not have.
  if (heading_deg && ExifText(exif, "Exif.GPSInfo.GPSImgDirectionRef") != "M") {
    metadata->yaw_rad = NormalizeAngle(DegToRad(*heading_deg));
  }
  const auto elevation_deg = ExifNumber(exif, "Exif.Photo.CameraElevationAngle");
  if (elevation_deg && std::abs(*elevation_deg) <= 90) {
    metadata->pitch_rad = DegToRad(*elevation_deg);
  }
  if (metadata->yaw_rad || metadata->pitch_rad) return;
  const auto yaw_deg = XmpNumber(xmp, "Xmp.drone-dji.GimbalYawDegree");
  const auto pitch_deg = XmpNumber(xmp, "Xmp.drone-dji.GimbalPitchDegree");
  const double roll_deg = XmpNumber(xmp, "Xmp.drone-dji.GimbalRollDegree").value_or(0);
  if (!yaw_deg || !pitch_deg) return;
  // Some DJI firmware writes three zeros whatever the gimbal does.
  if (*yaw_deg == 0 && *pitch_deg == 0 && roll_deg == 0) return;
  metadata->yaw_rad = NormalizeAngle(DegToRad(*yaw_deg));
  metadata->pitch_rad = DegToRad(*pitch_deg);
  metadata->roll_rad = NormalizeAngle(DegToRad(roll_deg));
}

void ReadAccuracy(const Exiv2::ExifData& exif, const Exiv2::XmpData& xmp, PhotoMetadata* metadata) {
  if (!metadata->gps) return;
  const auto above_zero = [](std::optional<double> value) {
    return value && *value > 0 ? value : std::nullopt;
  };
  const auto east_m = above_zero(XmpNumber(xmp, "Xmp.drone-dji.RtkStdLon"));
  const auto north_m = above_zero(XmpNumber(xmp, "Xmp.drone-dji.RtkStdLat"));
  const auto up_m = above_zero(XmpNumber(xmp, "Xmp.drone-dji.RtkStdHgt"));
  if (east_m && north_m && up_m) {
    metadata->gps_sigma_horizontal_m = std::max(*east_m, *north_m);
    metadata->gps_sigma_vertical_m = *up_m;
    return;
  }
  const auto error_m = above_zero(ExifNumber(exif, "Exif.GPSInfo.GPSHPositioningError"));
  if (!error_m) return;
  metadata->gps_sigma_horizontal_m = *error_m;
  metadata->gps_sigma_vertical_m = 2 * *error_m;
}

// "2021:08:20 07:34:45" to "2021-08-20T07:34:45"; empty when it is no such time.
std::string IsoTime(const std::string& exif_time, const std::string& fraction) {
  constexpr std::string_view kPattern = "dddd:dd:dd dd:dd:dd";
  if (exif_time.size() != kPattern.size() || exif_time.starts_with("0000")) return "";
  for (std::size_t i = 0; i < kPattern.size(); ++i) {
    const bool is_digit = exif_time[i] >= '0' && exif_time[i] <= '9';
    if (kPattern[i] == 'd' ? !is_digit : exif_time[i] != kPattern[i]) return "";
  }
  std::string time = exif_time;
  time[4] = time[7] = '-';
  time[10] = 'T';
  return fraction.empty() ? time : time + "." + fraction;
}

PhotoMetadata MetadataFromImage(const Exiv2::Image& image) {
  PhotoMetadata metadata;
  const Exiv2::ExifData& exif = image.exifData();
  metadata.width = static_cast<int>(image.pixelWidth());
  metadata.height = static_cast<int>(image.pixelHeight());
  metadata.camera_make = ExifText(exif, "Exif.Image.Make");
  metadata.camera_model = ExifText(exif, "Exif.Image.Model");
  metadata.gps = GpsFromExif(exif);
  metadata.focal_px = FocalFromExif(exif, metadata);
  metadata.capture_time = IsoTime(ExifText(exif, "Exif.Photo.DateTimeOriginal"),
                                  ExifText(exif, "Exif.Photo.SubSecTimeOriginal"));
  ReadDirection(exif, image.xmpData(), &metadata);
  ReadAccuracy(exif, image.xmpData(), &metadata);
  metadata.relative_height_m = XmpNumber(image.xmpData(), "Xmp.drone-dji.RelativeAltitude");
  return metadata;
}

// 1e-7 arc seconds are 3 micrometres on the ground, and 60e7 fits the 32 bits of a rational.
std::string ExifAngle(double magnitude_deg) {
  constexpr std::int64_t kTicksPerSecond = 10'000'000;
  const std::int64_t ticks = std::llround(magnitude_deg * 3600.0 * kTicksPerSecond);
  const std::int64_t ticks_per_minute = 60 * kTicksPerSecond;
  const std::int64_t minutes = ticks / ticks_per_minute;
  return std::to_string(minutes / 60) + "/1 " + std::to_string(minutes % 60) + "/1 " +
         std::to_string(ticks % ticks_per_minute) + "/" + std::to_string(kTicksPerSecond);
}

void SetGps(const GeoPosition& position, Exiv2::ExifData* exif) {
  if (!IsValid(position)) throw Error("the GPS position to be written into a photo is invalid");
  SetExif(exif, "Exif.GPSInfo.GPSVersionID", Exiv2::unsignedByte, "2 3 0 0");
  SetExif(exif, "Exif.GPSInfo.GPSLatitudeRef", Exiv2::asciiString,
          position.lat_deg < 0 ? "S" : "N");
  SetExif(exif, "Exif.GPSInfo.GPSLatitude", Exiv2::unsignedRational,
          ExifAngle(std::abs(position.lat_deg)));
  SetExif(exif, "Exif.GPSInfo.GPSLongitudeRef", Exiv2::asciiString,
          position.lon_deg < 0 ? "W" : "E");
  SetExif(exif, "Exif.GPSInfo.GPSLongitude", Exiv2::unsignedRational,
          ExifAngle(std::abs(position.lon_deg)));
  SetExif(exif, "Exif.GPSInfo.GPSAltitudeRef", Exiv2::unsignedByte,
          position.height_m < 0 ? "1" : "0");
  SetExif(exif, "Exif.GPSInfo.GPSAltitude", Exiv2::unsignedRational,
          ExifRational(std::abs(position.height_m), 10'000, "GPS altitude"));
}

void SetFocal(double focal_px, const std::string& camera_model, int long_side_px,
              Exiv2::ExifData* exif) {
  if (!(focal_px > 0) || long_side_px <= 0) {
    throw Error("the focal length to be written into a photo must be positive");
  }
  const double per_width = focal_px / long_side_px;
  const double sensor_mm = SensorWidthMm(camera_model).value_or(kFilmWidthMm);
  const long film_mm = std::lround(per_width * kFilmWidthMm);
  if (film_mm < 1 || film_mm > 65535) throw Error("the focal length does not fit its EXIF tag");
  SetExif(exif, "Exif.Photo.FocalLength", Exiv2::unsignedRational,
          ExifRational(per_width * sensor_mm, 1'000'000, "focal length"));
  SetExif(exif, "Exif.Photo.FocalLengthIn35mmFilm", Exiv2::unsignedShort, std::to_string(film_mm));
}

void SetDirection(const PhotoMetadata& metadata, Exiv2::ExifData* exif) {
  if (metadata.yaw_rad) {
    double heading_deg = RadToDeg(NormalizeAngle(*metadata.yaw_rad));
    if (heading_deg < 0) heading_deg += 360;
    SetExif(exif, "Exif.GPSInfo.GPSImgDirectionRef", Exiv2::asciiString, "T");
    SetExif(exif, "Exif.GPSInfo.GPSImgDirection", Exiv2::unsignedRational,
            ExifRational(heading_deg, 10'000'000, "heading"));
  }
  if (metadata.pitch_rad) {
    const double pitch_deg = RadToDeg(*metadata.pitch_rad);
    if (!(std::abs(pitch_deg) <= 90))
      throw Error("the pitch of a photo must be within ±90 degrees");
    SetExif(exif, "Exif.Photo.CameraElevationAngle", Exiv2::signedRational,
            std::to_string(std::llround(pitch_deg * 1e7)) + "/10000000");
  }
}

void SetCaptureTime(const std::string& iso_time, Exiv2::ExifData* exif) {
  std::string time = iso_time.substr(0, 19);
  if (time.size() == 19 && time[4] == '-' && time[7] == '-' && time[10] == 'T') {
    time[4] = time[7] = ':';
    time[10] = ' ';
  }
  const std::string fraction = iso_time.size() > 20 ? iso_time.substr(20) : "";
  if (IsoTime(time, fraction) != iso_time) {
    throw Error("capture time '" + iso_time + "' is not like 2021-08-20T07:34:45");
  }
  SetExif(exif, "Exif.Photo.DateTimeOriginal", Exiv2::asciiString, time);
  if (!fraction.empty()) {
    SetExif(exif, "Exif.Photo.SubSecTimeOriginal", Exiv2::asciiString, fraction);
  }
}

void ApplyMetadata(const PhotoMetadata& metadata, Exiv2::Image* image) {
  Exiv2::ExifData& exif = image->exifData();
  const auto set_text = [&exif](const char* key, const std::string& text) {
    if (!text.empty()) SetExif(&exif, key, Exiv2::asciiString, text);
  };
  set_text("Exif.Image.Make", metadata.camera_make);
  set_text("Exif.Image.Model", metadata.camera_model);
  if (metadata.gps) SetGps(*metadata.gps, &exif);
  if (metadata.focal_px) {
    SetFocal(*metadata.focal_px, ExifText(exif, "Exif.Image.Model"),
             static_cast<int>(std::max(image->pixelWidth(), image->pixelHeight())), &exif);
  }
  SetDirection(metadata, &exif);
  if (!metadata.capture_time.empty()) SetCaptureTime(metadata.capture_time, &exif);
}

// Exiv2's messages for the cases that people meet are unfriendly; ours name the file and the
// remedy.
[[noreturn]] void FailToRead(const std::filesystem::path& path, const std::string& reason) {
  throw Error(path.string() + ": cannot read it as a photo: " + reason);
}

}  // namespace

std::optional<double> SensorWidthMm(const std::string& camera_model) {
  for (const KnownSensor& sensor : kKnownSensors) {
    if (camera_model == sensor.camera_model) return sensor.width_mm;
  }
  return std::nullopt;
}

PhotoMetadata ReadPhotoMetadata(const std::filesystem::path& path) {
  PrepareExiv2();
  RequireFile(path, "photo");
  PhotoMetadata metadata;
  try {
    const auto image = Exiv2::ImageFactory::open(path.string());
    image->readMetadata();
    metadata = MetadataFromImage(*image);
  } catch (const std::exception& e) {  // Exiv2 has one hierarchy a version
    FailToRead(path, e.what());
  }
  if (metadata.width <= 0 || metadata.height <= 0) FailToRead(path, "it has no size");
  return metadata;
}

std::map<std::string, PhotoMetadata> ReadFolderMetadata(const std::filesystem::path& folder) {
  const std::vector<std::string> names = ListPhotos(folder);
  std::vector<PhotoMetadata> all(names.size());
  ParallelForEach(names.size(),
                  [&](std::size_t i) { all[i] = ReadPhotoMetadata(folder / names[i]); });
  std::map<std::string, PhotoMetadata> metadata_of_photo;
  for (std::size_t i = 0; i < names.size(); ++i) metadata_of_photo[names[i]] = std::move(all[i]);
  return metadata_of_photo;
}

std::string WithPhotoMetadata(const std::string& picture_bytes, const PhotoMetadata& metadata) {
  PrepareExiv2();
  try {
    const auto image =
        Exiv2::ImageFactory::open(reinterpret_cast<const Exiv2::byte*>(picture_bytes.data()),
                                  static_cast<long>(picture_bytes.size()));
    image->readMetadata();
    ApplyMetadata(metadata, image.get());
    image->writeMetadata();
    Exiv2::BasicIo& io = image->io();
    if (io.open() != 0) throw Error("the picture in memory cannot be opened");
    std::string result(static_cast<std::size_t>(io.size()), '\0');
    const auto num_read =
        io.read(reinterpret_cast<Exiv2::byte*>(result.data()), static_cast<long>(result.size()));
    if (static_cast<std::size_t>(num_read) != result.size()) {
      throw Error("the picture in memory cannot be read back");
    }
    return result;
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    throw Error(std::string("metadata cannot be written into the photo: ") + e.what());
  }
}

void WritePhotoMetadata(const PhotoMetadata& metadata, const std::filesystem::path& path) {
  RequireFile(path, "photo");
  std::string bytes;
  try {
    bytes = WithPhotoMetadata(ReadFile(path), metadata);
  } catch (const Error& e) {
    throw Error(path.string() + ": " + e.what());
  }
  WriteFileAtomically(path, bytes);
}

}  // namespace colmap_ext
