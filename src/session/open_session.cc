#include "session/open_session.h"

#include <algorithm>

#include "colmap_ext/mission/patterns.h"
#include "colmap_ext/report/summary_json.h"
#include "colmap_ext/scene/view_plan_io.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {
namespace {

namespace fs = std::filesystem;

// One line that says where the photos come from; a workspace keeps to it.
std::string SourceOf(const SessionInputs& inputs) {
  if (!inputs.scene.empty()) return "scene " + inputs.scene;
  if (!inputs.scene_path.empty()) return "scene file " + fs::absolute(inputs.scene_path).string();
  return "photos " + fs::absolute(inputs.image_path).lexically_normal().string();
}

}  // namespace

Session OpenSession(const SessionInputs& inputs, const StageOptions& options) {
  Session session{inputs, options, Workspace(inputs.workspace_path), {}, {}};
  const std::string source = SourceOf(inputs);
  if (fs::exists(session.workspace.state_json())) {
    session.state = ReadSessionState(session.workspace.state_json());
    if (session.state.source != source) {
      throw UsageError(inputs.workspace_path.string() + ": this workspace is of '" +
                       session.state.source + "', not of '" + source +
                       "'; choose another --workspace_path");
    }
    session.summary = ReadSummary(session.workspace.summary_json());
    // A session that was killed between the two files left one entry too many.
    const auto done = static_cast<std::size_t>(session.state.iterations_done);
    if (session.summary.iterations.size() < done) {
      throw Error(session.workspace.summary_json().string() + ": lacks iterations that " +
                  session.workspace.state_json().string() + " says are done");
    }
    session.summary.iterations.resize(done);
  }
  session.state.source = source;
  return session;
}

fs::path PhotoFolder(const Session& session) {
  return session.inputs.image_path.empty() ? session.workspace.images() : session.inputs.image_path;
}

bool IsFinished(const Session& session) {
  const std::string& finished = session.state.finished;
  const SessionOptions& limits = session.options.session;
  if (finished == "iteration_limit") return session.state.iterations_done >= limits.max_iterations;
  if (finished == "view_limit") {
    const IterationSummary& last = session.summary.iterations.back();
    return last.photos + last.planned_views > limits.max_photos;
  }
  if (finished == "covered") {
    const IterationSummary& last = session.summary.iterations.back();
    return last.planned_views == 0 ||
           last.reachable_covered_ratio.value_or(1.0) >= limits.target_covered_ratio;
  }
  return !finished.empty();
}

bool HasNewPhotos(const Session& session) {
  // What an interrupted iteration had to do is still to be done.
  if (session.summary.iterations.empty() || WasInterrupted(session)) return true;
  const std::vector<std::string> names = ListPhotos(session.inputs.image_path);
  if (!fs::exists(SeenPath(session.workspace))) {
    return static_cast<int>(names.size()) > session.summary.iterations.back().photos;
  }
  const SeenInputs seen = ReadSeenInputs(SeenPath(session.workspace));
  return std::any_of(names.begin(), names.end(),
                     [&seen](const std::string& name) { return !seen.photos.contains(name); });
}

bool WasInterrupted(const Session& session) {
  return fs::exists(session.workspace.iteration(session.state.iterations_done));
}

FlightPath FlightOfIteration(const Session& session, const RegionOfInterest& site) {
  if (session.state.iterations_done == 0) {
    return PathInOrder(InitialRectangle(site, session.options.initial_flight),
                       session.options.path.speed_m_s, session.options.path.hover_s);
  }
  const IterationFiles before{session.workspace.iteration(session.state.iterations_done - 1)};
  return ReadPath(before.path_json());
}

int CountViews(const std::vector<Waypoint>& waypoints) {
  return static_cast<int>(
      std::count_if(waypoints.begin(), waypoints.end(),
                    [](const Waypoint& waypoint) { return waypoint.view_id >= 0; }));
}

fs::path SeenPath(const Workspace& workspace) { return workspace.root() / "seen.json"; }

SeenInputs LookAtInputs(const Session& session) {
  OptionSet set;
  StageOptions options = session.options;
  BindOptions(set, &options);
  return LookAtInputs(PhotoFolder(session), session.workspace.database(), set.ToIni());
}

InputChanges ChangesSinceLastIteration(const Session& session) {
  const fs::path path = SeenPath(session.workspace);
  if (session.state.iterations_done == 0 || !fs::exists(path)) return {};
  return CompareInputs(ReadSeenInputs(path), LookAtInputs(session), PhotoFolder(session),
                       session.workspace.database(), WasInterrupted(session));
}

}  // namespace colmap_ext
