// The HTTP API of a simulated drone (docs/simulated_drone.md).
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"
#include "sim/drone_simulator_impl.h"

namespace colmap_ext {
namespace {

HttpResponse JsonAnswer(const Json& json) { return {200, "application/json", json.dump() + "\n"}; }

const std::string kPictures = "/pictures/";

}  // namespace

void DroneSimulator::Impl::Answer(const HttpRequest& request, HttpServer::Respond respond) {
  const std::string& path = request.target;
  const bool is_get = request.method == "GET";
  if (path == "/faults" && request.method == "POST") {
    Change(request.body);  // a complaint is answered with 400
    return respond(JsonAnswer(ToJson(faults)));
  }
  if (!is_get) return respond(HttpError(405, request.method + " is not allowed for " + path));
  if (path == "/faults") return respond(JsonAnswer(ToJson(faults)));
  if (path == "/status") return respond(JsonAnswer(Status()));
  if (path == "/pictures") return respond(JsonAnswer(PictureList()));
  if (path.starts_with(kPictures)) {
    return AnswerPicture(path.substr(kPictures.size()), std::move(respond));
  }
  respond(HttpError(404,
                    "there are /status, /faults, /pictures, /pictures/low/<name> and "
                    "/pictures/full/<name>"));
}

void DroneSimulator::Impl::AnswerPicture(const std::string& path, HttpServer::Respond respond) {
  const auto slash = path.find('/');
  const std::string folder = path.substr(0, slash);
  const std::string name = slash == std::string::npos ? "" : path.substr(slash + 1);
  if (folder != "low" && folder != "full") return respond(HttpError(404, "no picture " + path));
  const auto resolution = folder == "low" ? PhotoResolution::kLow : PhotoResolution::kFull;
  switch (pictures->StateOf(name, resolution)) {
    case PictureState::kUnknown:
      return respond(HttpError(404, "no picture " + path));
    case PictureState::kFailed:
      return respond(HttpError(500, "the picture could not be made"));
    case PictureState::kReady:
      return SendPicture(name, resolution, respond);
    case PictureState::kPending:
      waiting.emplace(std::pair(name, resolution), std::move(respond));
  }
}

void DroneSimulator::Impl::SendPicture(const std::string& name, PhotoResolution resolution,
                                       const HttpServer::Respond& respond) const {
  respond({200, "image/jpeg", ReadFile(pictures->PathOf(name, resolution))});
}

void DroneSimulator::Impl::PictureDone(const std::string& name, PhotoResolution resolution) {
  if (!http) return;
  const auto [begin, end] = waiting.equal_range({name, resolution});
  const bool is_ready = pictures->StateOf(name, resolution) == PictureState::kReady;
  for (auto each = begin; each != end; ++each) {
    if (is_ready) {
      SendPicture(name, resolution, each->second);
    } else {
      each->second(HttpError(500, "the picture could not be made"));
    }
  }
  waiting.erase(begin, end);
}

Json DroneSimulator::Impl::PictureList() const {
  Json list = Json::array();
  for (const PictureEntry& entry : pictures->List()) {
    const auto file = [&](const char* folder, PictureState state) {
      return Json{{"url", kPictures + folder + "/" + entry.name},
                  {"ready", state == PictureState::kReady}};
    };
    Json item = {{"index", entry.index},
                 {"time_boot_ms", entry.time_boot_ms},
                 {"name", entry.name},
                 {"low", file("low", entry.low)}};
    if (options.renders_full) item["full"] = file("full", entry.full);
    list.push_back(item);
  }
  return list;
}

}  // namespace colmap_ext
