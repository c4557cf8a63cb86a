#include "session/pictures.h"

#include "colmap_ext/report/mesh_picture.h"
#include "colmap_ext/report/photo_picture.h"
#include "colmap_ext/report/session_pictures.h"
#include "colmap_ext/report/view_overlay.h"

namespace colmap_ext {
namespace {

// Next to the paper's figures: the whole object, seen from where its photos were taken.
PictureView ViewOf(const IterationScenery& scenery) {
  PictureView view;
  view.focus = FocusOf(scenery.coverage, scenery.surface.mesh);
  return view;
}

}  // namespace

void WriteIterationPictures(const IterationScenery& scenery, const std::filesystem::path& folder) {
  const PosedPhoto& photo = scenery.photos.photos.back();
  const ViewMesh& mesh = scenery.views.back();
  WritePng(DrawSuperpixels(photo.bgr, mesh.image), folder / "superpixels.png");
  WritePng(DrawConfidence(photo.bgr, mesh), folder / "confidence.png");

  WriteViewOverlays(scenery.photos, scenery.views, folder.parent_path() / "overlays.json");

  const MeshPainter painter(scenery.surface.mesh);
  const PictureView view = ViewOf(scenery);
  WritePng(RenderSurface(painter, scenery.surface, view), folder / "surface.png");
  WritePng(RenderCoverageMap(painter, scenery.coverage, view), folder / "coverage.png");

  FlightPicture flight;
  for (const PosedPhoto& taken : scenery.photos.photos) {
    flight.photos.push_back(
        {taken.image_id, taken.name, taken.camera, taken.cam_from_world, {}, {}});
  }
  flight.views = scenery.planned;
  flight.path = scenery.path;
  PictureView flight_view;
  flight_view.direction = view.direction;
  WritePng(RenderFlightPath(painter, flight, flight_view), folder / "path.png");
}

}  // namespace colmap_ext
