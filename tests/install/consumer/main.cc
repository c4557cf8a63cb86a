// A program outside the project: does a photo see a wall, and with how many pixels a square metre?
#include <colmap_ext/coverage/projection_ratio.h>
#include <colmap_ext/coverage/visibility.h>

#include <cmath>
#include <iostream>

int main() {
  colmap_ext::TriangleMesh wall;  // x = 0, two metres wide and high, looking towards +x
  wall.vertices = {{0, -1, -1}, {0, 1, -1}, {0, 1, 1}, {0, -1, 1}};
  wall.faces = {{0, 1, 2}, {0, 2, 3}};
  const colmap_ext::PinholeCamera camera{640, 480, 500, 500, 320, 240};
  colmap_ext::Rigid3d cam_from_world;  // ten metres in front of it, looking at it
  cam_from_world.rotation = Eigen::Matrix3d{{0, 1, 0}, {0, 0, -1}, {-1, 0, 0}};
  cam_from_world.translation = {0, 0, 10};
  const double ratio =
      colmap_ext::ProjectionRatio(camera, cam_from_world, {0, 0, 0}, Eigen::Vector3d::UnitX());
  std::cout << ratio << " px² a m², " << colmap_ext::GetCameraModelInfo("OPENCV").num_params
            << " parameters\n";
  return std::abs(ratio - 2500) < 1e-6 ? 0 : 1;
}
