#include "flights.h"

#include "colmap_ext/mission/patterns.h"
#include "colmap_ext/util/error.h"

namespace colmap_ext {
namespace {

struct Ring {
  int num_views = 0;
  double height_ratio = 0;  // of the model's height above its lowest point; 0: above its top
  double pitch_deg = -30;
};

std::vector<Ring> RingsOf(const std::string& quality) {
  if (quality == "poor") return {{16, 0, -30}};
  if (quality == "middling") return {{40, 0, -30}};
  if (quality == "good") return {{40, 0, -30}, {28, 0.8, -18}, {28, 0.45, -6}};
  throw UsageError("flight \"" + quality + "\" is unknown; there are poor, middling and good");
}

}  // namespace

const std::vector<std::string>& FlightQualities() {
  static const std::vector<std::string> qualities = {"poor", "middling", "good"};
  return qualities;
}

std::vector<PlannedView> FlightOf(const std::string& quality, const BoundingBox& model,
                                  bool indoor) {
  std::vector<PlannedView> views;
  for (const Ring& ring : RingsOf(quality)) {
    InitialFlightOptions options;
    options.num_views = ring.num_views;
    options.pitch_deg = ring.pitch_deg;
    options.offset_m = indoor ? 1.0 : 10.0;
    options.height_above_top_m = indoor ? 0.2 : 2.0;
    if (ring.height_ratio > 0) {
      options.height_m = model.min().z() + ring.height_ratio * model.sizes().z();
    }
    for (PlannedView view : InitialRectangle({model}, options)) {
      view.id = static_cast<int>(views.size());
      views.push_back(view);
    }
  }
  return views;
}

}  // namespace colmap_ext
