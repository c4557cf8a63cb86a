#include <gtest/gtest.h>

#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "colmap_ext/util/files.h"
#include "simple_scenes.h"

namespace colmap_ext {
namespace {

using test::ErrorOf;
using test::RecordingSink;
using test::ScratchFolder;

const LoadSceneOptions kNoGround = [] {
  LoadSceneOptions options;
  options.add_ground = false;
  return options;
}();

TexturedScene TexturedCube() {
  TexturedScene scene;
  Material checker;
  checker.name = "checker";
  checker.texture_bgr = cv::Mat(64, 64, CV_8UC3, cv::Scalar(30, 60, 200));
  checker.texture_bgr(cv::Rect(0, 0, 32, 32)).setTo(cv::Scalar(220, 40, 20));
  checker.texture_bgr(cv::Rect(40, 32, 10, 20)).setTo(cv::Scalar(20, 220, 20));
  scene.materials = {checker, test::FlatMaterial(90)};
  test::AddCube({-1, 3, 0.5}, 2, 0, 1, &scene);
  test::AddCube({1.5, 4, 0.5}, 1, 1, 2, &scene);
  return scene;
}

double MeanDifference(const TexturedScene& a, const TexturedScene& b) {
  RenderOptions options;
  options.ambient_rays = 0;
  const Rigid3d pose = CamFromWorld({0.5, -2, 2.5}, {0.05, DegToRad(-12)});
  const cv::Mat one = Renderer(a, options).Render(test::SmallCamera(), pose);
  const cv::Mat two = Renderer(b, options).Render(test::SmallCamera(), pose);
  return cv::norm(one, two, cv::NORM_L1) / (3.0 * static_cast<double>(one.total()));
}

TEST(SceneFiles, ObjComesBackAsTheSameSceneAndLooksTheSame) {
  const ScratchFolder folder("obj");
  const TexturedScene scene = TexturedCube();
  WriteScene(scene, folder.path(), "cube");
  const TexturedScene back = LoadScene(folder / "cube.obj", kNoGround, JobControl());
  EXPECT_EQ(back.mesh.faces.size(), scene.mesh.faces.size());
  EXPECT_TRUE(BoundsOf(back.mesh).isApprox(BoundsOf(scene.mesh), 1e-6));
  EXPECT_LT(MeanDifference(scene, back), 0.5);
  EXPECT_EQ(back.Truth().model.faces.size(), scene.mesh.faces.size());
}

TEST(SceneFiles, ProceduralSceneSurvivesTheRoundTrip) {
  const ScratchFolder folder("boxes");
  const TexturedScene scene = MakeScene("boxes", 1, 8);
  WriteScene(scene, folder.path(), "boxes");
  for (const Material& material : scene.materials) {
    EXPECT_FALSE(cv::imread((folder / ("boxes_" + material.name + ".png")).string()).empty());
  }
  const TexturedScene back = LoadScene(folder / "boxes.obj", kNoGround, JobControl());
  EXPECT_EQ(back.mesh.faces.size(), scene.mesh.faces.size());
  EXPECT_TRUE(BoundsOf(back.mesh).isApprox(BoundsOf(scene.mesh), 1e-6));
  EXPECT_LT(MeanDifference(scene, back), 2);
}

TEST(SceneFiles, GroundIsAddedBelowAndIsNotTruth) {
  const ScratchFolder folder("ground");
  WriteScene(TexturedCube(), folder.path(), "cube");
  const TexturedScene scene = LoadScene(folder / "cube.obj", {}, JobControl());
  const GroundTruth truth = scene.Truth();
  EXPECT_EQ(truth.model.faces.size(), 24u);
  EXPECT_GT(scene.mesh.faces.size(), 24u);
  const BoundingBox all = BoundsOf(scene.mesh), model = BoundsOf(truth.model);
  EXPECT_NEAR(all.min().z(), model.min().z(), 0.01);
  EXPECT_LE(all.min().z(), model.min().z());
  EXPECT_GT(all.sizes().x(), 4 * model.sizes().x());
  EXPECT_EQ(truth.origin.lat_deg, kDefaultSceneOrigin.lat_deg);
}

std::string Collada(const std::string& unit, const std::string& up, const std::string& texture) {
  return R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>)" +
         unit + "<up_axis>" + up + R"(</up_axis></asset>
<library_images><image id="img"><init_from>)" +
         texture + R"(</init_from></image></library_images>
<library_effects><effect id="fx"><profile_COMMON>
<newparam sid="s"><surface type="2D"><init_from>img</init_from></surface></newparam>
<newparam sid="t"><sampler2D><source>s</source></sampler2D></newparam>
<technique sid="c"><lambert><diffuse><texture texture="t" texcoord="UV"/></diffuse></lambert></technique>
</profile_COMMON></effect></library_effects>
<library_materials><material id="mat"><instance_effect url="#fx"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">0 0 0 100 0 0 0 0 200</float_array>
<technique_common><accessor source="#pa" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<source id="u"><float_array id="ua" count="6">0 0 1 0 0 1</float_array>
<technique_common><accessor source="#ua" count="3" stride="2"><param name="S" type="float"/>
<param name="T" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1" material="m"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="TEXCOORD" source="#u" offset="1" set="0"/><p>0 0 1 1 2 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="vs"><node><instance_geometry url="#g"><bind_material>
<technique_common><instance_material symbol="m" target="#mat">
<bind_vertex_input semantic="UV" input_semantic="TEXCOORD" input_set="0"/></instance_material>
</technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#vs"/></scene></COLLADA>)";
}

// The triangle stands 200 units tall along the file's z and is 100 wide along x.
TEST(SceneFiles, ColladaUnitAndUpAxisAreObeyed) {
  const ScratchFolder folder("dae");
  cv::imwrite((folder / "t.png").string(), cv::Mat(8, 8, CV_8UC3, cv::Scalar(1, 2, 3)));
  const auto size_of = [&](const std::string& unit, const std::string& up) -> Eigen::Vector3d {
    WriteFileAtomically(folder / "a.dae", Collada(unit, up, "t.png"));
    const TexturedScene scene = LoadScene(folder / "a.dae", kNoGround, JobControl());
    EXPECT_FALSE(scene.materials.at(0).texture_bgr.empty());
    return BoundsOf(scene.mesh).sizes();
  };
  const std::string inch = R"(<unit name="inch" meter="0.0254"/>)";
  EXPECT_TRUE(size_of(inch, "Z_UP").isApprox(Eigen::Vector3d(2.54, 0, 5.08), 1e-5));
  EXPECT_TRUE(size_of("", "Z_UP").isApprox(Eigen::Vector3d(100, 0, 200), 1e-5));
  EXPECT_TRUE(size_of(inch, "Y_UP").isApprox(Eigen::Vector3d(2.54, 5.08, 0), 1e-5));
}

TEST(SceneFiles, MissingTextureIsAWarningAndAFlatColour) {
  const ScratchFolder folder("texture");
  WriteFileAtomically(folder / "a.dae", Collada("", "Z_UP", "gone.jpg"));
  RecordingSink sink;
  const TexturedScene scene = LoadScene(folder / "a.dae", kNoGround, JobControl(&sink, nullptr));
  EXPECT_TRUE(scene.materials.at(0).texture_bgr.empty());
  ASSERT_EQ(sink.warnings.size(), 1u);
  EXPECT_NE(sink.warnings[0].find("gone.jpg"), std::string::npos);
  // A file that is there but no picture is the same case.
  WriteFileAtomically(folder / "gone.jpg", "no picture");
  sink.warnings.clear();
  LoadScene(folder / "a.dae", kNoGround, JobControl(&sink, nullptr));
  EXPECT_EQ(sink.warnings.size(), 1u);
}

std::string Base64(const std::string& bytes) {
  static const char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (int k = 3; k >= 0; --k) text += kDigits[group >> (6 * k) & 63U];
  }
  for (std::size_t k = 0; k < (3 - bytes.size() % 3) % 3; ++k) text[text.size() - 1 - k] = '=';
  return text;
}

std::string Gltf() {
  const float positions[] = {0, 0, 0, 1, 0, 0, 0, 3, 0};  // 3 m tall in glTF's y
  std::string bytes(sizeof(positions), '\0');
  std::memcpy(bytes.data(), positions, sizeof(positions));
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,3,0]}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)" +
         Base64(bytes) + R"("}]})";
}

TEST(SceneFiles, GltfStandsUpright) {
  const ScratchFolder folder("gltf");
  WriteFileAtomically(folder / "a.gltf", Gltf());
  const TexturedScene scene = LoadScene(folder / "a.gltf", kNoGround, JobControl());
  EXPECT_TRUE(BoundsOf(scene.mesh).sizes().isApprox(Eigen::Vector3d(1, 0, 3), 1e-6));
}

TEST(SceneFiles, BrokenFilesAreNamed) {
  const ScratchFolder folder("broken");
  const auto message = [&](const std::string& name) {
    return ErrorOf([&] { LoadScene(folder / name, kNoGround, JobControl()); });
  };
  EXPECT_NE(message("none.obj").find("none.obj"), std::string::npos);
  WriteFileAtomically(folder / "garbage.dae", "this is no model");
  EXPECT_NE(message("garbage.dae").find("garbage.dae"), std::string::npos);
  const std::string whole = Collada("", "Z_UP", "t.png");
  WriteFileAtomically(folder / "half.dae", whole.substr(0, whole.size() / 2));
  EXPECT_NE(message("half.dae").find("half.dae"), std::string::npos);
  WriteFileAtomically(folder / "half.gltf", Gltf().substr(0, 200));
  EXPECT_NE(message("half.gltf").find("half.gltf"), std::string::npos);
  WriteFileAtomically(folder / "empty.obj", "");
  EXPECT_NE(message("empty.obj").find("empty.obj"), std::string::npos);
  WriteFileAtomically(folder / "points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
  EXPECT_NE(message("points.obj").find("points.obj"), std::string::npos);
  WriteFileAtomically(folder / "a.unknown", "v 0 0 0");
  EXPECT_NE(message("a.unknown").find("a.unknown"), std::string::npos);
  EXPECT_EQ(message("garbage.dae").find('\n'), std::string::npos);
}

TEST(SceneFiles, WritingWhereOneCannotIsAnError) {
  const ScratchFolder folder("readonly");
  WriteFileAtomically(folder / "file", "not a folder");
  EXPECT_THROW(WriteScene(TexturedCube(), folder / "file", "cube"), Error);
}

}  // namespace
}  // namespace colmap_ext
