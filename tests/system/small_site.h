// A small site for whole commands: photos and their sparse model.
#pragma once

#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "colmap_ext/scene/reconstruction_io.h"
#include "mvs/analytic_scene.h"
#include "program.h"

namespace colmap_ext {

class SmallSite : public ProgramTest {
 protected:
  // A box on a floor, seven photos and their sparse model, as `images` and `sparse`.
  SmallSite() {
    test::AnalyticScene scene;
    scene.rectangles.push_back({{-15, -15, 0}, {30, 0, 0}, {0, 30, 0}, {120, 140, 130}, 1, 50});
    scene.rectangles.push_back({{-1.5, -1.5, 2.5}, {3, 0, 0}, {0, 3, 0}, {50, 60, 200}, 4, 50});
    scene.rectangles.push_back({{-1.5, -1.5, 0}, {3, 0, 0}, {0, 0, 2.5}, {190, 70, 60}, 7, 50});
    scene.rectangles.push_back({{1.5, -1.5, 0}, {0, 3, 0}, {0, 0, 2.5}, {60, 170, 80}, 10, 50});
    std::vector<Rigid3d> poses;
    for (int i = 0; i < 7; ++i) {
      const double angle = 0.5 + 0.14 * (i - 3);
      poses.push_back(test::LookAt({9 * std::sin(angle), -9 * std::cos(angle), 6}, {0, 0, 0.5}));
    }
    const test::AnalyticSurvey survey = test::Survey(scene, test::TestCamera(), poses, 500);
    Reconstruction model;
    model.cameras[1] = ToCamera(test::TestCamera());
    std::filesystem::create_directories(folder_ / "images");
    for (const PosedPhoto& photo : survey.photos.photos) {
      model.images[photo.image_id] = {photo.name, 1, photo.cam_from_world, {}};
      cv::imwrite((folder_ / "images" / photo.name).string(), photo.bgr);
    }
    for (const SupportPoint& support : survey.photos.points) {
      const Point3DId id = model.points.size() + 1;
      SparsePoint& point = model.points[id];
      point.position = support.position;
      point.error_px = support.error_px;
      for (const int index : support.photo_indices) {
        const PosedPhoto& photo = survey.photos.photos[static_cast<std::size_t>(index)];
        SparseImage& image = model.images.at(photo.image_id);
        point.track.push_back({photo.image_id, static_cast<std::uint32_t>(image.keypoints.size())});
        image.keypoints.push_back(
            {photo.camera.Project(photo.cam_from_world * support.position), id});
      }
    }
    WriteReconstructionBinary(model, folder_ / "sparse");
  }

  ChildProcessResult RunColmap(const std::vector<std::string>& arguments) const {
    ChildProcessOptions options;
    options.arguments = arguments;
    options.environment = {{"QT_QPA_PLATFORM", "offscreen"}, {"OMP_WAIT_POLICY", "passive"}};
    return RunChildProcess(options, JobControl());
  }
};

}  // namespace colmap_ext
