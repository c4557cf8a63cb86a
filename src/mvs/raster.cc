#include "mvs/raster.h"

namespace colmap_ext {

cv::Mat1i RasterizeTriangleIds(const ImageMesh& mesh, int width, int height) {
  cv::Mat1i ids(height, width, -1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3i& corner = mesh.triangles[t];
    const auto& vertices = mesh.vertices_px;
    ForEachPixelInTriangle(vertices[static_cast<std::size_t>(corner[0])],
                           vertices[static_cast<std::size_t>(corner[1])],
                           vertices[static_cast<std::size_t>(corner[2])], width, height, 1,
                           [&](int x, int y) { ids(y, x) = static_cast<int>(t); });
  }
  return ids;
}

Eigen::Vector3d Barycentric(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                            const Eigen::Vector2d& c, const Eigen::Vector2d& pixel) {
  const double area = Cross(a, b, c);
  const double beta = Cross(a, pixel, c) / area;
  const double gamma = Cross(a, b, pixel) / area;
  return {1.0 - beta - gamma, beta, gamma};
}

}  // namespace colmap_ext
