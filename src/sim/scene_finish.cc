// The second half of SceneBuilder: textures are packed and painted, hidden faces dropped.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "colmap_ext/util/parallel.h"
#include "sim/face_visibility.h"
#include "sim/scene_builder.h"

namespace colmap_ext {
namespace {

// Texels painted past a chart's border, so that filtering does not fetch a neighbour's colour.
constexpr int kGutter = 3;
constexpr int kRowsPerJob = 64;
constexpr double kMinArea = 1e-9;  // m²

cv::Vec3b ToBgr(const Eigen::Vector3f& rgb) {
  const auto byte = [](float value) {
    return static_cast<unsigned char>(std::clamp(value, 0.0F, 1.0F) * 255.0F + 0.5F);
  };
  return {byte(rgb.z()), byte(rgb.y()), byte(rgb.x())};
}

}  // namespace

// Shelf packing, tallest charts first. Returns the texture's size.
cv::Size SceneBuilder::PackCharts(int material) {
  const double texel = materials_[static_cast<std::size_t>(material)].texel_m;
  std::vector<Chart*> charts;
  int widest = 64;
  double area = 0;
  for (Chart& chart : charts_) {
    if (chart.material != material || !chart.used) continue;
    chart.width = static_cast<int>(std::ceil(chart.size_m.x() / texel)) + 2 * kGutter;
    chart.height = static_cast<int>(std::ceil(chart.size_m.y() / texel)) + 2 * kGutter;
    widest = std::max(widest, chart.width);
    area += static_cast<double>(chart.width) * chart.height;
    charts.push_back(&chart);
  }
  std::stable_sort(charts.begin(), charts.end(),
                   [](const Chart* a, const Chart* b) { return a->height > b->height; });
  const int width = std::max(widest, static_cast<int>(std::ceil(std::sqrt(area))));
  int x = 0, y = 0, shelf = 0;
  for (Chart* chart : charts) {
    if (x + chart->width > width) {
      x = 0;
      y += shelf;
      shelf = 0;
    }
    chart->x = x;
    chart->y = y;
    x += chart->width;
    shelf = std::max(shelf, chart->height);
  }
  return {width, y + std::max(shelf, 1)};
}

void SceneBuilder::PaintChart(const Chart& chart, std::uint32_t seed, cv::Mat* texture) const {
  const MaterialEntry& material = materials_[static_cast<std::size_t>(chart.material)];
  const int jobs = (chart.height + kRowsPerJob - 1) / kRowsPerJob;
  ParallelFor(jobs, [&](int job) {
    SurfacePoint point;
    point.size = chart.size_m.cast<float>();
    point.seed = seed;
    const int end = std::min(chart.height, (job + 1) * kRowsPerJob);
    for (int row = job * kRowsPerJob; row < end; ++row) {
      auto* texels = texture->ptr<cv::Vec3b>(chart.y + row) + chart.x;
      for (int col = 0; col < chart.width; ++col) {
        const Eigen::Vector2d at((col + 0.5 - kGutter) * material.texel_m,
                                 (chart.height - kGutter - row - 0.5) * material.texel_m);
        point.chart = at.cast<float>();
        point.uv = (chart.pattern_origin + at).cast<float>();
        point.world = chart.world_at(at).cast<float>();
        texels[col] = ToBgr(material.painter(point));
      }
    }
  });
}

cv::Mat SceneBuilder::PaintMaterial(int material, const cv::Size& size) const {
  cv::Mat texture(size, CV_8UC3, cv::Scalar(128, 128, 128));
  ParallelFor(charts_.size(), [&](std::size_t i) {
    if (charts_[i].material != material || !charts_[i].used) return;
    PaintChart(charts_[i], seed_ + static_cast<std::uint32_t>(i) * 7919U, &texture);
  });
  return texture;
}

// Only charts of which something is seen get a place in the texture.
void SceneBuilder::MarkUsedCharts(const std::vector<bool>& keep_face) {
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    const auto vertex = static_cast<std::size_t>(faces_[i][0]);
    if (keep_face[i]) charts_[static_cast<std::size_t>(vertices_[vertex].chart)].used = true;
  }
}

Eigen::Vector2f SceneBuilder::TextureCoordinates(int index,
                                                 const std::vector<cv::Size>& sizes) const {
  const Vertex& vertex = vertices_[static_cast<std::size_t>(index)];
  const Chart& chart = charts_[static_cast<std::size_t>(vertex.chart)];
  const auto m = static_cast<std::size_t>(chart.material);
  const Eigen::Vector2d texel = vertex.chart_m / materials_[m].texel_m;
  const double x = chart.x + kGutter + texel.x();
  const double y_from_top = chart.y + chart.height - kGutter - texel.y();
  return Eigen::Vector2d(x / sizes[m].width, 1 - y_from_top / sizes[m].height).cast<float>();
}

TexturedScene SceneBuilder::Finish(const GeoPosition& origin) {
  TexturedScene scene;
  scene.origin = origin;
  for (const Vertex& vertex : vertices_) scene.mesh.vertices.push_back(vertex.world);
  scene.mesh.faces = faces_;
  scene.object_of_face = object_of_face_;
  std::vector<bool> keep = FindVisibleFaces(scene.mesh, scene.object_of_face);
  // Where slopes run out to a point, strips leave triangles without area.
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (FaceArea(scene.mesh, i) < kMinArea) keep[i] = false;
  }
  MarkUsedCharts(keep);
  std::vector<cv::Size> sizes;
  for (int m = 0; m < static_cast<int>(materials_.size()); ++m) {
    sizes.push_back(PackCharts(m));
    Material material;
    material.name = materials_[static_cast<std::size_t>(m)].name;
    material.texture_bgr = PaintMaterial(m, sizes.back());
    scene.materials.push_back(std::move(material));
  }
  for (const auto& face : faces_) {
    scene.corner_uv.push_back({TextureCoordinates(face[0], sizes),
                               TextureCoordinates(face[1], sizes),
                               TextureCoordinates(face[2], sizes)});
    const auto chart = vertices_[static_cast<std::size_t>(face[0])].chart;
    scene.material_of_face.push_back(charts_[static_cast<std::size_t>(chart)].material);
  }
  KeepFaces(keep, &scene);
  for (const auto& n : VertexNormals(scene.mesh)) scene.vertex_normals.push_back(n.cast<float>());
  return scene;
}

}  // namespace colmap_ext
