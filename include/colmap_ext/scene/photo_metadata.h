// What a photo file says about itself (EXIF and XMP).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "colmap_ext/geom/geodesy.h"

namespace colmap_ext {

struct PhotoMetadata {
  int width = 0;   // px, of the picture itself; tags may be stale after a resize
  int height = 0;  // px
  // Only when latitude, longitude and altitude are all there and valid, and the receiver had a fix.
  std::optional<GeoPosition> gps;
  // From FocalLength and the sensor width where we know the camera model, else from the 35 mm
  // equivalent (36 mm along the longer side). FocalPlaneXResolution is not used: it may be stale
  // after a resize. A photo cropped along its longer side would get a wrong value; nothing in a
  // file tells.
  std::optional<double> focal_px;
  std::string camera_make;
  std::string camera_model;
  // Where the camera looked (conventions of ViewDirection). From GPSImgDirection (true north) and
  // CameraElevationAngle, else from DJI's gimbal angles unless all of them read 0 (then nobody
  // wrote them).
  std::optional<double> yaw_rad;
  std::optional<double> pitch_rad;
  // About the optical axis, positive when the camera leans to its right. Only from DJI's gimbal
  // angles.
  std::optional<double> roll_rad;
  // Accuracy of `gps`, one sigma of an axis: from DJI's RTK tags, else from GPSHPositioningError
  // (the vertical one is then taken as twice the horizontal one).
  std::optional<double> gps_sigma_horizontal_m;
  std::optional<double> gps_sigma_vertical_m;
  // Above the place of take-off, metres: DJI's RelativeAltitude.
  std::optional<double> relative_height_m;
  std::string
      capture_time;  // ISO 8601 without zone, "2021-08-20T07:34:45" or with ".123"; empty: unknown
};

// Reads the metadata of one photo. A photo without EXIF is fine: only its size is known then.
// Throws Error naming the file when it is missing or no picture. Thread-safe.
PhotoMetadata ReadPhotoMetadata(const std::filesystem::path& path);

// The photos below `folder` by the names of ListPhotos, read in parallel. Throws as above, naming
// the first bad photo.
std::map<std::string, PhotoMetadata> ReadFolderMetadata(const std::filesystem::path& folder);

// The bytes of a JPEG, PNG or TIFF file with `metadata` written into its EXIF; other tags are kept,
// fields that are not set are left alone; width, height, roll, accuracies and relative_height_m are
// not used. Position comes back within 0.1 mm, focal_px within 1e-4 px when the camera model is one
// whose sensor width we know (kSimulatedModel is one), else within the 1 mm of
// FocalLengthIn35mmFilm. Throws Error when the picture or a value cannot be written.
std::string WithPhotoMetadata(const std::string& picture_bytes, const PhotoMetadata& metadata);

// The same for a file, replaced atomically.
void WritePhotoMetadata(const PhotoMetadata& metadata, const std::filesystem::path& path);

// Make and model for simulated photos: a sensor 36 mm wide.
inline constexpr const char* kSimulatedMake = "colmap_ext";
inline constexpr const char* kSimulatedModel = "simulated camera";

// Width in mm of the sensor area that a full-width photo of this camera model shows; nullopt:
// unknown.
std::optional<double> SensorWidthMm(const std::string& camera_model);

}  // namespace colmap_ext
