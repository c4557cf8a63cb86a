#include "colmap_ext/dense/options.h"

#include <sstream>

namespace colmap_ext {
namespace {

// Collects the first complaint.
class RangeCheck {
 public:
  RangeCheck& In(const char* name, double value, double low, double high) {
    if (complaint_.empty() && !(value >= low && value <= high)) {
      std::ostringstream text;
      text << "DenseStereo." << name << " is " << value << ", must be in [" << low << ", " << high
           << "]";
      complaint_ = text.str();
    }
    return *this;
  }
  RangeCheck& That(bool is_well, const char* complaint) {
    if (complaint_.empty() && !is_well) complaint_ = std::string("DenseStereo.") + complaint;
    return *this;
  }
  const std::string& complaint() const { return complaint_; }

 private:
  std::string complaint_;
};

}  // namespace

std::string DenseStereoOptions::Check() const {
  RangeCheck check;
  if (max_width_px != 0) check.In("max_width_px", max_width_px, 64, 65536);
  check.In("num_partners", num_partners, 1, 32)
      .That(min_angle_deg > 0 && good_angle_deg >= min_angle_deg &&
                max_angle_deg > good_angle_deg && max_angle_deg <= 90,
            "angles must be 0 < min_angle_deg <= good_angle_deg < max_angle_deg <= 90")
      .In("coarse_width_px", coarse_width_px, 64, 4096)
      .In("residual_px", residual_px, 8, 64)
      .That(residual_px % 8 == 0, "residual_px must be a multiple of 8")
      .In("block_px", block_px, 1, 11)
      .That(block_px % 2 == 1, "block_px must be odd")
      .In("uniqueness_percent", uniqueness_percent, 0, 50)
      .That(agreement_px > 0 && agreement_px <= 8, "agreement_px must be in (0, 8]")
      .In("plane_window_px", plane_window_px, 3, 15)
      .That(plane_window_px % 2 == 1, "plane_window_px must be odd")
      .That(max_reprojection_px > 0 && max_reprojection_px <= 8,
            "max_reprojection_px must be in (0, 8]")
      .That(max_depth_error > 0 && max_depth_error <= 0.2, "max_depth_error must be in (0, 0.2]")
      .In("min_photos", min_photos, 1, 20)
      .In("fusion_step_px", fusion_step_px, 1, 16)
      .In("max_memory_mib", max_memory_mib, 256, 1e6);
  return check.complaint();
}

void BindOptions(OptionSet& set, DenseStereoOptions* o) {
  const std::string section = "DenseStereo";
  set.Add(section, "max_width_px", &o->max_width_px,
          "wider photos are scaled down to this width (px; 0: full size)");
  set.Add(section, "num_partners", &o->num_partners,
          "photos that each one is matched with [1, 32]");
  set.Add(section, "min_angle_deg", &o->min_angle_deg,
          "triangulation angle below which shared points count less");
  set.Add(section, "good_angle_deg", &o->good_angle_deg,
          "triangulation angle above which shared points count less");
  set.Add(section, "max_angle_deg", &o->max_angle_deg,
          "triangulation angle from which shared points do not count, up to 90");
  set.Add(section, "coarse_width_px", &o->coarse_width_px,
          "width of the level where the whole depth range is searched (px) [64, 4096]");
  set.Add(section, "residual_px", &o->residual_px,
          "search of the finer levels, px to either side, a multiple of 8 [8, 64]");
  set.Add(section, "block_px", &o->block_px, "side of the matching window, px, odd [1, 11]");
  set.Add(section, "uniqueness_percent", &o->uniqueness_percent,
          "margin of the best match over the second best [0, 50]");
  set.Add(section, "agreement_px", &o->agreement_px,
          "parallax within which two pairs agree on a depth, px (0, 8]");
  set.Add(section, "plane_window_px", &o->plane_window_px,
          "window of the plane that smooths depth and gives normals, px, odd [3, 15]");
  set.Add(section, "max_reprojection_px", &o->max_reprojection_px,
          "a point confirmed by another photo's map comes back within this, px (0, 8]");
  set.Add(section, "max_depth_error", &o->max_depth_error,
          "... and its depth differs by less than this share (0, 0.2]");
  set.Add(section, "min_photos", &o->min_photos,
          "photos that must agree on a depth, itself counted [1, 20]");
  set.Add(section, "fusion_step_px", &o->fusion_step_px,
          "every so many pixels give a fused point [1, 16]");
  set.Add(section, "max_memory_mib", &o->max_memory_mib,
          "memory that matching may use, MiB [256, 1e6]");
}

}  // namespace colmap_ext
