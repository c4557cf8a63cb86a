#include "colmap_ext/dense/builtin.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/util/files.h"
#include "dense/wall_survey.h"
#include "scene/test_folder.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using test::WallScene;
using test::WallSurvey;
using test::WriteSurvey;

DenseStereoOptions SmallOptions() {
  DenseStereoOptions options;
  options.coarse_width_px = 120;
  options.residual_px = 8;
  options.num_partners = 3;
  return options;
}

// Collects what is said, and asks to stop after `stop_after` steps of a stage.
class Listener : public ProgressSink {
 public:
  explicit Listener(std::string stage = "", std::size_t stop_after = 0)
      : stage_(std::move(stage)), stop_after_(stop_after) {}
  void Message(LogLevel, std::string_view text) override {
    const std::lock_guard lock(mutex_);
    messages += std::string(text) + "\n";
  }
  void Progress(std::string_view stage, std::size_t done, std::size_t) override {
    if (stage == stage_ && done == stop_after_) cancel = true;
  }

  std::atomic<bool> cancel = false;
  std::string messages;

 private:
  std::mutex mutex_;
  std::string stage_;
  std::size_t stop_after_;
};

class Builtin : public ::testing::Test {
 protected:
  explicit Builtin(int num_photos = 4) : survey_(WallSurvey(num_photos)) {
    model_ = WriteSurvey(WallScene(), survey_, folder_ / "images");
  }

  OrientedPoints Run(const std::string& name, Listener* listener = nullptr,
                     const DenseStereoOptions& options = SmallOptions()) const {
    const PhotoSource photos(model_, folder_ / "images", 0);
    DenseRequest request;
    request.photos = &photos;
    request.workspace_path = folder_ / name;
    Listener silent;
    Listener& sink = listener == nullptr ? silent : *listener;
    return ReconstructBuiltin(request, options, JobControl(&sink, &sink.cancel));
  }

  // All files below stereo/ and the points, as text.
  std::string Bytes(const std::string& name, const OrientedPoints& points) const {
    WriteOrientedPoints(points, folder_ / "points.ply");
    std::string bytes = ReadFile(folder_ / "points.ply");
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / name / "stereo")) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) bytes += file.filename().string() + ReadFile(file);
    return bytes;
  }

  TestFolder folder_;
  test::AnalyticSurvey survey_;
  Reconstruction model_;
};

TEST_F(Builtin, ReconstructsTheWallAndThePanel) {
  const OrientedPoints points = Run("a");
  ASSERT_GT(points.size(), 5000U);
  std::vector<double> distances;
  int on_panel = 0;
  for (const OrientedPoint& point : points) {
    double nearest = 1e9;
    for (const test::Rectangle& r : WallScene().rectangles) {
      nearest = std::min(nearest, std::abs(r.Normal().dot(point.position - r.origin)));
    }
    on_panel += std::abs(point.position.y() - 6.5) < 0.1;
    distances.push_back(nearest);
    EXPECT_LT(point.normal.y(), 0.3);
    EXPECT_GE(point.confidence, 0.5);
  }
  std::sort(distances.begin(), distances.end());
  EXPECT_LT(distances[distances.size() / 2], 0.035);  // 0.06 px of parallax
  EXPECT_LT(distances[distances.size() * 9 / 10], 0.1);
  EXPECT_GT(on_panel, 500);
}

TEST_F(Builtin, WritesColmapsDenseWorkspace) {
  Run("a");
  const DenseWorkspace workspace{folder_ / "a"};
  for (const PosedPhoto& photo : survey_.photos.photos) {
    const DenseMap depth = ReadDenseMap(workspace.depth_map(photo.name));
    EXPECT_EQ(depth.width, 240);
    const DenseMap normal = ReadDenseMap(workspace.normal_map(photo.name));
    EXPECT_EQ(normal.channels, 3);
    EXPECT_EQ(ReadDenseMap(workspace.confidence_map(photo.name)).channels, 1);
    EXPECT_TRUE(fs::exists(workspace.images() / photo.name));
    EXPECT_NEAR(depth.At(80, 120), survey_.depth[photo.image_id - 1](80, 120), 0.1);
  }
  EXPECT_TRUE(fs::exists(workspace.sparse() / "cameras.bin"));
  EXPECT_NE(ReadFile(workspace.stereo() / "patch-match.cfg").find(", "), std::string::npos);
}

// More photos than are worked on when a run is stopped.
class StoppedBuiltin : public Builtin {
 protected:
  StoppedBuiltin() : Builtin(6) {}
};

TEST_F(StoppedBuiltin, GoesOnWhereItWasAndGivesTheSameBytes) {
  const std::string whole = Bytes("whole", Run("whole"));
  for (const auto& [stage, steps] :
       {std::pair<std::string, std::size_t>{"depth maps", 2}, {"consistency", 1}}) {
    Listener stopped(stage, steps);
    EXPECT_THROW(Run(stage, &stopped), CancelledError);
    Listener again;
    const OrientedPoints points = Run(stage, &again);
    EXPECT_NE(again.messages.find("are there from an earlier run"), std::string::npos)
        << again.messages;
    EXPECT_TRUE(Bytes(stage, points) == whole) << stage;
  }
}

TEST_F(Builtin, DoesNotDependOnTheNumberOfThreads) {
  const std::string many = Bytes("many", Run("many"));
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_TRUE(Bytes("one", Run("one")) == many);
}

TEST_F(Builtin, StartsAgainWhenOptionsOrPhotosChanged) {
  Run("a");
  DenseStereoOptions options = SmallOptions();
  options.block_px = 7;
  Listener listener;
  const OrientedPoints changed = Run("a", &listener, options);
  EXPECT_NE(listener.messages.find("starting again"), std::string::npos);
  EXPECT_TRUE(Bytes("a", changed) == Bytes("fresh", Run("fresh", nullptr, options)));
  // What only concerns fusion keeps the maps.
  options.fusion_step_px = 4;
  Listener quiet;
  Run("a", &quiet, options);
  EXPECT_EQ(quiet.messages.find("starting again"), std::string::npos);
}

TEST_F(Builtin, NamesPhotosWithoutPartnersAndRefusesAModelWithoutPoints) {
  for (auto& [id, point] : model_.points) {
    std::erase_if(point.track, [](const TrackElement& e) { return e.image_id == 1; });
  }
  model_.images[1].keypoints.clear();
  Listener listener;
  EXPECT_GT(Run("a", &listener).size(), 1000U);
  EXPECT_NE(listener.messages.find("photo_100.png: shares too few points"), std::string::npos);
  model_.points.clear();
  for (auto& [id, image] : model_.images) image.keypoints.clear();
  ExpectError([&] { Run("b"); }, {"no photo shares enough points", "point_triangulator"});
}

TEST_F(Builtin, MatchesLargerPhotosThanTheModels) {
  WriteSurvey(WallScene(), survey_, folder_ / "large", 2);
  const PhotoSource photos(model_, folder_ / "large", 0);
  EXPECT_EQ(photos.photo_set().photos[0].camera.width, 480);
  EXPECT_EQ(photos.photo_set().photos[0].camera.fx, 440);
  DenseRequest request;
  request.photos = &photos;
  request.workspace_path = folder_ / "out";
  request.region = BoundingBox(Eigen::Vector3d(-1, 5, -1), Eigen::Vector3d(1, 8, 1));
  const OrientedPoints points = ReconstructBuiltin(request, SmallOptions(), JobControl());
  double sum = 0;
  for (const OrientedPoint& point : points) {
    EXPECT_TRUE(request.region.contains(point.position));
    sum += std::abs(point.position.y() - 6.5);
  }
  EXPECT_LT(sum / static_cast<double>(points.size()), 0.02);
}

TEST_F(Builtin, TakesTheDepthRangeFromAFastModel) {
  DenseMap far(10, 10, 1);
  std::fill(far.data.begin(), far.data.end(), 40.0F);
  const DenseWorkspace prior{folder_ / "prior"};
  WriteDenseMap(far, prior.depth_map("photo_100.png"));
  const auto without = DepthRanges(survey_.photos, "");
  const auto with = DepthRanges(survey_.photos, prior.folder);
  EXPECT_NEAR(with[0].max, 60, 1e-3);
  EXPECT_LT(without[0].max, 25);
  EXPECT_EQ(with[1].max, without[1].max);
}

TEST(PhotoSource, UndistortsAndRefusesOtherShapes) {
  TestFolder folder;
  const test::AnalyticSurvey survey = WallSurvey(2);
  Reconstruction model = WriteSurvey(WallScene(), survey, folder / "images");
  Camera& camera = model.cameras[1];
  camera.model = CameraModel::kRadial;
  camera.params = {220, 120, 80, 0.1, 0.02};
  const PhotoSource photos(model, folder / "images", 0);
  // A pixel of the ideal picture shows what the distorted camera has at its image of the same ray.
  const cv::Mat picture = photos.Load(0);
  const cv::Mat& original = survey.photos.photos[0].bgr;
  const Eigen::Vector3d ray = photos.photo_set().photos[0].camera.Ray({200.5, 130.5});
  const Eigen::Vector2d at = ImageFromNormalized(camera, ray.head<2>());
  cv::Mat expected;
  cv::getRectSubPix(original, cv::Size(1, 1),
                    cv::Point2f(static_cast<float>(at.x() - 0.5), static_cast<float>(at.y() - 0.5)),
                    expected);
  EXPECT_NEAR(picture.at<cv::Vec3b>(130, 200)[1], expected.at<cv::Vec3b>(0, 0)[1], 3);
  const Reconstruction pinhole = photos.PinholeModel();
  EXPECT_EQ(pinhole.cameras.size(), 2U);
  for (const auto& [id, c] : pinhole.cameras) EXPECT_TRUE(IsPinhole(c));
  camera.height = 240;
  ExpectError([&] { PhotoSource(model, folder / "images", 0); }, {"photo_100.png", "shape"});
}

TEST(StereoPartners, PreferNeighboursThatShareManyPointsAtGoodAngles) {
  const test::AnalyticSurvey survey = WallSurvey(8);
  DenseStereoOptions options;
  options.num_partners = 3;
  const auto partners = ChooseStereoPartners(survey.photos, options);
  ASSERT_EQ(partners[0].size(), 3U);
  for (const int j : partners[0]) EXPECT_LE(j, 5);
  for (std::size_t i = 0; i < partners.size(); ++i) {
    for (const int j : partners[i]) EXPECT_NE(static_cast<int>(i), j);
  }
  PhotoSet lonely = survey.photos;
  lonely.points.clear();
  for (const auto& list : ChooseStereoPartners(lonely, options)) EXPECT_TRUE(list.empty());
  EXPECT_FALSE(RangeOfDepths({1, 2}).IsKnown());
  const DepthRange range = RangeOfDepths({9, 10, 11, 10, 10, 10});
  EXPECT_NEAR(range.min, 0.7 * 9, 1e-6);
  EXPECT_NEAR(range.max, 1.5 * 11, 1e-6);
}

TEST(DenseStereoOptions, ComplainsByName) {
  EXPECT_EQ(DenseStereoOptions().Check(), "");
  DenseStereoOptions options;
  options.residual_px = 12;
  EXPECT_NE(options.Check().find("DenseStereo.residual_px"), std::string::npos);
  options = DenseStereoOptions();
  options.max_angle_deg = 10;
  EXPECT_NE(options.Check().find("max_angle_deg"), std::string::npos);
  options = DenseStereoOptions();
  options.max_memory_mib = 1;
  EXPECT_NE(options.Check().find("max_memory_mib"), std::string::npos);
}

}  // namespace
}  // namespace colmap_ext
