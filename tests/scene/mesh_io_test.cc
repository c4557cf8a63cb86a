#include "colmap_ext/scene/mesh_io.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "colmap_ext/scene/coverage_map_io.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/util/files.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

// Numbers with all their digits: what float32 could not hold.
Eigen::Vector3d RandomVector(std::mt19937_64* random) {
  std::uniform_real_distribution<double> uniform(-1000, 1000);
  return {uniform(*random), uniform(*random), uniform(*random)};
}

Surface RandomSurface() {
  std::mt19937_64 random(1);
  std::uniform_int_distribution<int> vertex(0, 49);
  Surface surface;
  for (int i = 0; i < 50; ++i) {
    surface.mesh.vertices.push_back(RandomVector(&random));
    surface.sample_spacing_m.push_back(RandomVector(&random).norm());
    surface.scatter_m.push_back(RandomVector(&random).norm());
    surface.color.emplace_back(i / 49.0, 1 - i / 49.0, 0.123);
  }
  for (int i = 0; i < 80; ++i) {
    surface.mesh.faces.emplace_back(vertex(random), vertex(random), vertex(random));
  }
  return surface;
}

void WriteAscii(const std::filesystem::path& path, const std::string& vertices,
                const std::string& faces) {
  WriteFileAtomically(
      path,
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_index\n"
      "end_header\n" +
          vertices + faces);
}

TEST(MeshIo, ASurfaceComesBackExactlyButForItsColours) {
  const TestFolder folder;
  const Surface written = RandomSurface();
  WriteSurface(written, folder / "surface.ply");
  const Surface read = ReadSurface(folder / "surface.ply");
  EXPECT_EQ(read.mesh.vertices, written.mesh.vertices);
  EXPECT_EQ(read.mesh.faces, written.mesh.faces);
  EXPECT_EQ(read.sample_spacing_m, written.sample_spacing_m);
  EXPECT_EQ(read.scatter_m, written.scatter_m);
  ASSERT_EQ(read.color.size(), written.color.size());
  for (std::size_t i = 0; i < read.color.size(); ++i) {
    EXPECT_LE((read.color[i] - written.color[i]).cwiseAbs().maxCoeff(), 0.5 / 255 + 1e-12);
  }
}

TEST(MeshIo, WritingWhatWasReadChangesNothing) {
  const TestFolder folder;
  WriteSurface(RandomSurface(), folder / "a.ply");
  WriteSurface(ReadSurface(folder / "a.ply"), folder / "b.ply");
  EXPECT_EQ(ReadFile(folder / "a.ply"), ReadFile(folder / "b.ply"));
}

TEST(MeshIo, AMeshKeepsItsColoursOrHasNone) {
  const TestFolder folder;
  const Surface surface = RandomSurface();
  WriteMesh(surface.mesh, folder / "plain.ply");
  EXPECT_TRUE(ReadColoredMesh(folder / "plain.ply").color.empty());
  EXPECT_EQ(ReadMesh(folder / "plain.ply").faces, surface.mesh.faces);
  WriteMesh(surface.mesh, surface.color, folder / "colored.ply");
  EXPECT_EQ(ReadColoredMesh(folder / "colored.ply").color.size(), surface.mesh.vertices.size());
  // Names that viewers know.
  const std::string header = ReadFile(folder / "colored.ply").substr(0, 400);
  for (const char* line : {"property double x\n", "property uchar red\n",
                           "property list uchar int vertex_indices\n"}) {
    EXPECT_NE(header.find(line), std::string::npos) << line;
  }
}

TEST(MeshIo, AnEmptyMeshComesBackEmpty) {
  const TestFolder folder;
  WriteMesh({}, folder / "empty.ply");
  const TriangleMesh mesh = ReadMesh(folder / "empty.ply");
  EXPECT_TRUE(mesh.vertices.empty());
  EXPECT_TRUE(mesh.faces.empty());
}

TEST(MeshIo, PolygonsOfOthersBecomeFans) {
  const TestFolder folder;
  WriteAscii(folder / "quad.ply", "0 0 0\n1 0 0\n1 1 0\n0 1 0\n", "4 0 1 2 3\n");
  const TriangleMesh mesh = ReadMesh(folder / "quad.ply");
  ASSERT_EQ(mesh.faces.size(), 2U);
  EXPECT_EQ(mesh.faces[0], Eigen::Vector3i(0, 1, 2));
  EXPECT_EQ(mesh.faces[1], Eigen::Vector3i(0, 2, 3));
}

TEST(MeshIo, BadMeshesAreNamedByVertexOrFace) {
  const TestFolder folder;
  const std::string good = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  WriteAscii(folder / "a.ply", good, "3 0 1 4\n");
  ExpectError([&] { ReadMesh(folder / "a.ply"); }, {"a.ply: face 0", "4 vertices"});
  WriteAscii(folder / "a.ply", good, "3 0 1 -1\n");
  ExpectError([&] { ReadMesh(folder / "a.ply"); }, {"a.ply: face 0"});
  WriteAscii(folder / "a.ply", good, "2 0 1\n");
  ExpectError([&] { ReadMesh(folder / "a.ply"); }, {"a.ply: face 0", "three corners"});
  WriteAscii(folder / "a.ply", "0 0 0\n1 0 inf\n1 1 0\n0 1 0\n", "3 0 1 2\n");
  ExpectError([&] { ReadMesh(folder / "a.ply"); }, {"a.ply: vertex 1", "z is not a finite"});
  WriteMesh(RandomSurface().mesh, folder / "a.ply");
  ExpectError([&] { ReadSurface(folder / "a.ply"); }, {"a.ply", "sample_spacing_m"});
}

TEST(MeshIo, ASurfaceOfAnEarlierVersionHasNoScatter) {
  const TestFolder folder;
  Surface surface = RandomSurface();
  surface.scatter_m.clear();
  WriteSurface(surface, folder / "surface.ply");
  EXPECT_TRUE(ReadSurface(folder / "surface.ply").scatter_m.empty());
}

TEST(MeshIo, WhatIsNotFiniteOrInconsistentIsNotWritten) {
  const TestFolder folder;
  Surface surface = RandomSurface();
  surface.mesh.vertices[7].y() = kNoNumber;
  ExpectError([&] { WriteSurface(surface, folder / "a.ply"); }, {"a.ply", "vertex 7"});
  surface = RandomSurface();
  surface.sample_spacing_m[3] = kNoNumber;
  ExpectError([&] { WriteSurface(surface, folder / "a.ply"); }, {"a.ply", "vertex 3"});
  surface = RandomSurface();
  surface.sample_spacing_m.pop_back();
  ExpectError([&] { WriteSurface(surface, folder / "a.ply"); }, {"49 values", "50 vertices"});
  surface = RandomSurface();
  surface.scatter_m[4] = kNoNumber;
  ExpectError([&] { WriteSurface(surface, folder / "a.ply"); }, {"scatter_m", "vertex 4"});
  surface = RandomSurface();
  surface.mesh.faces[5][1] = 50;
  ExpectError([&] { WriteSurface(surface, folder / "a.ply"); }, {"face 5"});
  surface = RandomSurface();
  surface.color.pop_back();
  ExpectError([&] { WriteSurface(surface, folder / "a.ply"); }, {"49 colours"});
  EXPECT_FALSE(std::filesystem::exists(folder / "a.ply"));
}

TEST(OrientedPointsIo, PointsComeBackExactly) {
  const TestFolder folder;
  std::mt19937_64 random(2);
  OrientedPoints written;
  for (int i = 0; i < 100; ++i) {
    OrientedPoint point;
    point.position = RandomVector(&random);
    point.normal = RandomVector(&random).normalized();
    point.color = {static_cast<std::uint8_t>(i), 255, 0};
    point.confidence = static_cast<float>(i) / 99.0F;
    point.photo_index = i - 1;
    written.push_back(point);
  }
  WriteOrientedPoints(written, folder / "fused.ply");
  const OrientedPoints read = ReadOrientedPoints(folder / "fused.ply");
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].position, written[i].position);
    EXPECT_EQ(read[i].normal, written[i].normal);
    EXPECT_EQ(read[i].color, written[i].color);
    EXPECT_EQ(read[i].confidence, written[i].confidence);
    EXPECT_EQ(read[i].photo_index, written[i].photo_index);
  }
  written[4].normal.x() = kNoNumber;
  ExpectError([&] { WriteOrientedPoints(written, folder / "x.ply"); }, {"x.ply", "point 4"});
}

TEST(OrientedPointsIo, COLMAPsFusedCloudIsRead) {
  const TestFolder folder;
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  WriteFileAtomically(folder / "fused.ply", header + "1 2 3 0 0 1 10 20 30\n");
  const OrientedPoints points = ReadOrientedPoints(folder / "fused.ply");
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0].position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(points[0].color[2], 30);
  EXPECT_EQ(points[0].confidence, 1.0F);
  EXPECT_EQ(points[0].photo_index, -1);
  WriteMesh(RandomSurface().mesh, folder / "mesh.ply");
  ExpectError([&] { ReadOrientedPoints(folder / "mesh.ply"); }, {"mesh.ply", "property nx"});
}

CoverageMap RandomCoverageMap() {
  std::mt19937_64 random(3);
  CoverageMap map;
  map.disk_area_m2 = 0.1 + 1e-17;
  map.min_projection_ratio = 1234.567890123456789;
  map.target_error_mm = 25.4;
  for (int i = 0; i < 30; ++i) {
    IsoPoint point;
    point.position = RandomVector(&random);
    point.normal = RandomVector(&random).normalized();
    point.coverage = static_cast<CoverageClass>(i % 3 == 2 ? 2 : i % 2);
    point.sample_spacing_m = RandomVector(&random).norm();
    point.scatter_m = RandomVector(&random).norm();
    point.num_good_views = i;
    point.best_projection_ratio = RandomVector(&random).norm();
    point.predicted_error_mm = i % 4 == 0 ? -1 : RandomVector(&random).norm();
    point.score = i / 30.0;
    map.points.push_back(point);
  }
  return map;
}

TEST(CoverageMapIo, TheMapComesBackExactly) {
  const TestFolder folder;
  const CoverageMap written = RandomCoverageMap();
  WriteCoverageMap(written, folder / "coverage.ply");
  const CoverageMap read = ReadCoverageMap(folder / "coverage.ply");
  EXPECT_EQ(read.disk_area_m2, written.disk_area_m2);
  EXPECT_EQ(read.min_projection_ratio, written.min_projection_ratio);
  EXPECT_EQ(read.target_error_mm, written.target_error_mm);
  ASSERT_EQ(read.points.size(), written.points.size());
  for (std::size_t i = 0; i < read.points.size(); ++i) {
    EXPECT_EQ(read.points[i].position, written.points[i].position);
    EXPECT_EQ(read.points[i].normal, written.points[i].normal);
    EXPECT_EQ(read.points[i].coverage, written.points[i].coverage);
    EXPECT_EQ(read.points[i].sample_spacing_m, written.points[i].sample_spacing_m);
    EXPECT_EQ(read.points[i].scatter_m, written.points[i].scatter_m);
    EXPECT_EQ(read.points[i].num_good_views, written.points[i].num_good_views);
    EXPECT_EQ(read.points[i].best_projection_ratio, written.points[i].best_projection_ratio);
    EXPECT_EQ(read.points[i].predicted_error_mm, written.points[i].predicted_error_mm);
    EXPECT_EQ(read.points[i].score, written.points[i].score);
  }
  // Another program sees the classes as colours.
  const OrientedPoints seen = ReadOrientedPoints(folder / "coverage.ply");
  for (std::size_t i = 0; i < seen.size(); ++i) {
    int strongest = 0;
    seen[i].color.maxCoeff(&strongest);
    EXPECT_EQ(strongest, static_cast<int>(written.points[i].coverage));  // red, green, blue
  }
}

TEST(CoverageMapIo, BadMapsAreRefused) {
  const TestFolder folder;
  WriteCoverageMap(RandomCoverageMap(), folder / "a.ply");
  std::string bytes = ReadFile(folder / "a.ply");
  bytes.replace(bytes.find("comment disk_area_m2"), 20, "comment disk_area_xx");
  WriteFileAtomically(folder / "a.ply", bytes);
  ExpectError([&] { ReadCoverageMap(folder / "a.ply"); }, {"a.ply", "disk_area_m2"});
  CoverageMap map = RandomCoverageMap();
  map.points[2].predicted_error_mm = kNoNumber;
  ExpectError([&] { WriteCoverageMap(map, folder / "b.ply"); }, {"b.ply", "iso-point 2"});
}

TEST(CoverageMap, CountsAndRatioLeaveIgnoredPointsOut) {
  const CoverageMap map = RandomCoverageMap();
  EXPECT_EQ(map.Count(CoverageClass::kIgnored), 10U);
  EXPECT_EQ(map.Count(CoverageClass::kCovered), 10U);
  EXPECT_EQ(map.Count(CoverageClass::kUncovered), 10U);
  EXPECT_EQ(map.CoveredRatio(), 0.5);
  EXPECT_EQ(CoverageMap{}.CoveredRatio(), 1.0);
}

}  // namespace
}  // namespace colmap_ext
