// Readers of files. The bytes are written to a file, or to the files of a folder, and read: what
// comes back is a value or an Error, and what was read can be written and read again.
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "colmap_ext/coverage/region.h"
#include "colmap_ext/mvs/stereo_memory_io.h"
#include "colmap_ext/nbv/next_best_views.h"
#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/scene/capture_journal.h"
#include "colmap_ext/scene/coverage_map_io.h"
#include "colmap_ext/scene/dense_map.h"
#include "colmap_ext/scene/flight_limits.h"
#include "colmap_ext/scene/las.h"
#include "colmap_ext/scene/mesh_io.h"
#include "colmap_ext/scene/oriented_points_io.h"
#include "colmap_ext/scene/photo_metadata.h"
#include "colmap_ext/scene/position_file.h"
#include "colmap_ext/scene/reconstruction_io.h"
#include "colmap_ext/scene/true_poses.h"
#include "colmap_ext/scene/view_plan_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "colmap_ext/util/options.h"
#include "fuzz/targets.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;
using Bytes = std::span<const std::uint8_t>;

// A folder of this process, for input and for what is written again.
class Scratch {
 public:
  Scratch() : root_(fs::temp_directory_path() / ("fuzz_files_" + std::to_string(getpid()))) {
    fs::create_directories(root_ / "model");
    fs::create_directories(root_ / "again");
  }
  ~Scratch() { fs::remove_all(root_); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  fs::path Write(const std::string& name, Bytes bytes) const {
    const fs::path path = root_ / name;
    std::ofstream stream(path, std::ios::binary | std::ios::trunc);
    stream.write(reinterpret_cast<const char*>(bytes.data()),
                 static_cast<std::streamsize>(bytes.size()));
    return path;
  }
  const fs::path& root() const { return root_; }

 private:
  fs::path root_;
};

const Scratch& Folder() {
  static const Scratch scratch;
  return scratch;
}

// Whether `read` gave a value; an Error is as good.
template <typename Read>
bool Reads(const Read& read) {
  try {
    read();
    return true;
  } catch (const Error&) {
    return false;
  }
}

// The files of a model: each with two bytes of length before it, in this order.
void ReadModel(Bytes bytes, const char* extension) {
  constexpr std::array kNames = {"cameras", "images", "points3D", "rigs", "frames"};
  const fs::path folder = Folder().root() / "model";
  for (const char* name : kNames) {
    const std::string file = std::string("model/") + name + extension;
    fs::remove(Folder().root() / file);
    if (bytes.size() < 2) continue;
    const std::size_t length =
        std::min<std::size_t>(bytes[0] + std::size_t{256} * bytes[1], bytes.size() - 2);
    Folder().Write(file, bytes.subspan(2, length));
    bytes = bytes.subspan(2 + length);
  }
  Reads([&] {
    const Reconstruction model = ReadReconstruction(folder);
    const fs::path again = Folder().root() / "again";
    WriteReconstructionBinary(model, again);
    const Reconstruction copy = ReadReconstruction(again);
    Promise(copy.images.size() == model.images.size() &&
                copy.points.size() == model.points.size() &&
                copy.cameras.size() == model.cameras.size(),
            "a model that was read comes back");
  });
}

}  // namespace

void FuzzColmapBinary(Bytes bytes) { ReadModel(bytes, ".bin"); }
void FuzzColmapText(Bytes bytes) { ReadModel(bytes, ".txt"); }

void FuzzStereoMemory(Bytes bytes) {
  const fs::path path = Folder().Write("stereo.bin", bytes);
  StereoMemory memory;
  if (!Reads([&] { ReadStereoMemory(path, &memory); })) return;
  std::set<std::string> names;
  for (const auto& [name, settled] : memory.photo) names.insert(name);
  WriteStereoMemory(memory, names, path);
  const std::string written = ReadFile(path);
  StereoMemory again;
  ReadStereoMemory(path, &again);
  WriteStereoMemory(again, names, path);
  Promise(ReadFile(path) == written, "meshes of photos come back");
}

void FuzzDenseMap(Bytes bytes) {
  const fs::path path = Folder().Write("map.bin", bytes);
  Reads([&] {
    const DenseMap map = ReadDenseMap(path);
    WriteDenseMap(map, path);
    const DenseMap copy = ReadDenseMap(path);
    Promise(copy.width == map.width && copy.height == map.height && copy.channels == map.channels,
            "a map that was read comes back");
  });
}

void FuzzPly(Bytes bytes) {
  const fs::path path = Folder().Write("mesh.ply", bytes);
  Reads([&] {
    const ColoredMesh mesh = ReadColoredMesh(path);
    for (const auto& face : mesh.mesh.faces) {
      for (const int corner : face) {
        Promise(corner >= 0 && static_cast<std::size_t>(corner) < mesh.mesh.vertices.size(),
                "every corner of a face is a vertex");
      }
    }
  });
  Reads([&] { ReadSurface(path); });
  Reads([&] { ReadOrientedPoints(path); });
  Reads([&] { ReadCoverageMap(path); });
}

void FuzzObj(Bytes bytes) {
  const fs::path path = Folder().Write("mesh.obj", bytes);
  Reads([&] { ReadMesh(path); });
}

void FuzzLas(Bytes bytes) {
  const fs::path path = Folder().Write("scan.las", bytes);
  Reads([&] { ReadLasPoints(path); });
}

void FuzzExif(Bytes bytes) {
  const fs::path path = Folder().Write("photo.jpg", bytes);
  Reads([&] { ReadPhotoMetadata(path); });
}

void FuzzGeoJson(Bytes bytes) {
  const fs::path path = Folder().Write("zones.geojson", bytes);
  const WorldFrame on_earth{true, GeoPosition{47.4, 8.5, 400}};
  for (const WorldFrame& frame : {on_earth, WorldFrame{true, std::nullopt}}) {
    Reads([&] {
      const FlightLimits limits = ReadFlightLimits(path, frame);
      Promise(!limits.zones.empty(), "a file of zones has a zone");
    });
    Reads([&] { ReadPolygon(path, frame); });
  }
}

void FuzzPositions(Bytes bytes) {
  const fs::path path = Folder().Write("geo.txt", bytes);
  Reads([&] {
    for (const auto& [name, position] : ReadGeoFile(path)) {
      Promise(IsValid(position), "what was read lies on Earth");
    }
  });
  Reads([&] { ReadPosePriorFile(path); });
  Reads([&] { ReadTruePoses(path); });
}

void FuzzIni(Bytes bytes) {
  const fs::path path = Folder().Write("session.ini", bytes);
  NextBestViewOptions options;
  OptionSet set;
  BindOptions(set, &options);
  Reads([&] {
    set.ParseIniFile(path);
    options.Check();
  });
}

void FuzzWorkspaceJson(Bytes bytes) {
  const fs::path path = Folder().Write("views.json", bytes);
  Reads([&] { ReadViews(path); });
  Reads([&] { ReadPath(path); });
  Reads([&] { ReadWorldFrame(path); });
  Reads([&] { ReadSummary(path); });
  Reads([&] { ReadStageSeconds(path); });
}

void FuzzCaptureJournal(Bytes bytes) {
  const fs::path path = Folder().Write("capture.jsonl", bytes);
  Reads([&] { ReadCaptureJournal(path); });
}

}  // namespace colmap_ext
