#include <cmath>
#include <vector>

#include "colmap_ext/scene/json_file.h"
#include "colmap_ext/sfm/georegistration.h"
#include "colmap_ext/sfm/sparse_update.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

double Rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return values.empty() ? 0 : std::sqrt(sum / static_cast<double>(values.size()));
}

double HorizontalM(const PhotoResidual& residual) { return residual.offset_m.head<2>().norm(); }

Json PhotosOf(const GeoregistrationResult& result) {
  Json photos = Json::array();
  for (const PhotoResidual& residual : result.residuals) {
    photos.push_back(
        {{"name", residual.name},
         {"residual_m", residual.residual_m},
         {"horizontal_m", HorizontalM(residual)},
         {"vertical_m", residual.offset_m.z()},
         {"offset_enu_m", {residual.offset_m.x(), residual.offset_m.y(), residual.offset_m.z()}},
         {"agrees", !residual.is_outlier}});
  }
  return photos;
}

}  // namespace

std::string GeoregistrationReport(const GeoregistrationResult& result) {
  std::vector<double> horizontal, vertical;
  for (const PhotoResidual& residual : result.residuals) {
    if (residual.is_outlier) continue;
    horizontal.push_back(HorizontalM(residual));
    vertical.push_back(residual.offset_m.z());
  }
  Json json;
  json["georegistered"] = result.world_from_model.has_value();
  if (!result.world_from_model) {
    json["refusal"] = result.refusal;
  } else {
    json["scale"] = result.world_from_model->scale;
    json["positions_used"] = result.num_used;
    json["attitudes_used"] = result.num_attitudes;
    json["gravity_from_cameras"] = result.gravity_from_cameras;
    json["tilt_uncertainty_deg"] = result.tilt_uncertainty_deg;
    json["rms_m"] = result.rms_m;
    json["rms_horizontal_m"] = Rms(horizontal);
    json["rms_vertical_m"] = Rms(vertical);
    json["max_m"] = result.max_m;
    json["disagreeing"] = Json::array();
    for (const PhotoResidual& outlier : result.outliers)
      json["disagreeing"].push_back(outlier.name);
    json["photos"] = PhotosOf(result);
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

void WriteGeoregistration(const SparseUpdateResult& result, const std::filesystem::path& folder) {
  if (!result.positions) return;
  WriteFileAtomically(folder / "georegistration.json", GeoregistrationReport(*result.positions));
}

}  // namespace colmap_ext
