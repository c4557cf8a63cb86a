#include <algorithm>
#include <array>
#include <iostream>
#include <map>

#include "ask_yes.h"
#include "colmap_ext/flight/dry_run.h"
#include "colmap_ext/flight/flight_client.h"
#include "colmap_ext/flight/flight_options.h"
#include "colmap_ext/flight/plan_mission.h"
#include "colmap_ext/util/error.h"
#include "command_line.h"
#include "commands.h"

namespace colmap_ext {
namespace {

constexpr std::array kActions = {"status", "load",  "preflight", "start",  "pause",
                                 "resume", "abort", "watch",     "dry_run"};

struct ClientInputs {
  std::filesystem::path workspace_path;
  std::filesystem::path mission_path;
  std::string how = "rtl";
  std::string stack = "px4";
  bool yes = false;
};

FlightClient Connect(const ClientInputs& inputs) {
  const auto address = FindDaemon(inputs.workspace_path);
  if (!address) {
    throw Error(inputs.workspace_path.string() +
                ": no flight daemon runs for this workspace; start colmap_ext_flightd");
  }
  return FlightClient(*address);
}

void PrintStatus(const Json& status) {
  const Json& vehicle = status.at("vehicle");
  std::cout << status.at("state").get<std::string>();
  if (const auto reason = status.at("reason").get<std::string>(); !reason.empty()) {
    std::cout << ": " << reason;
  }
  std::cout << "\nvehicle: " << vehicle.at("description").get<std::string>() << ", "
            << vehicle.at("mode").get<std::string>()
            << (vehicle.at("armed").get<bool>() ? ", armed" : ", disarmed");
  if (vehicle.contains("relative_height_m")) {
    std::cout << ", " << vehicle.at("relative_height_m") << " m above home";
  }
  if (vehicle.contains("battery_percent")) {
    std::cout << ", battery " << vehicle.at("battery_percent") << " %";
  }
  std::map<std::string, int> counts;
  for (const Json& view : status.at("views")) ++counts[view.at("status").get<std::string>()];
  std::cout << "\nviews:";
  for (const auto& [name, count] : counts) std::cout << ' ' << count << ' ' << name;
  std::cout << '\n';
  for (const Json& item : status.at("preflight")) {
    std::cout << (item.at("good").get<bool>() ? "  good  " : "  BAD   ")
              << item.at("name").get<std::string>() << ": " << item.at("text").get<std::string>()
              << '\n';
  }
}

// A person types yes before anything arms.
void AskBeforeStart(const FlightClient& client, const ClientInputs& inputs, const JobControl& job) {
  PrintStatus(client.Status());
  std::string checklist;
  const std::filesystem::path path = inputs.workspace_path / "flight" / "mission.json";
  if (std::filesystem::exists(path)) {
    const FlightMission mission = MissionFromJson(ReadJsonFile(path), path.string());
    const FlightOptions flight;
    checklist = ChecklistText(
        MakeChecklist(mission, flight.percent_per_minute, flight.reserve_percent), mission);
  }
  if (inputs.yes) {
    std::cout << checklist;
  } else if (!AskYes(checklist, job)) {
    throw Error("not started");
  }
}

void WatchEvents(const FlightClient& client, const std::atomic<bool>& cancel) {
  const auto goes_on = [&cancel] { return !cancel.load(); };
  client.Watch(
      0,
      [&](const Json& event) {
        std::cout << event.dump() << std::endl;
        return goes_on();
      },
      goes_on);
}

// Without daemon and vehicle.
int DryRun(const ClientInputs& inputs) {
  RequireOption(inputs.mission_path, "mission_path");
  if (inputs.stack != "px4" && inputs.stack != "ardupilot") {
    throw UsageError("--stack " + inputs.stack + ": must be px4 or ardupilot");
  }
  const FlightMission mission =
      MissionFromJson(ReadJsonFile(inputs.mission_path), inputs.mission_path.string());
  const FlightOptions flight;
  std::cout << ChecklistText(
                   MakeChecklist(mission, flight.percent_per_minute, flight.reserve_percent),
                   mission)
            << DryRunText(mission,
                          inputs.stack == "px4" ? AutopilotStack::kPx4 : AutopilotStack::kArduPilot,
                          {0, 0, mission.home_z_m.value_or(0)}, flight.takeoff_height_m);
  return 0;
}

int Perform(const std::string& action, const ClientInputs& inputs, Program& program) {
  if (action == "dry_run") return DryRun(inputs);
  const auto show = [&program](const Json& status) {
    PrintStatus(status);
    program.log.Result({{"status", status}});
  };
  const FlightClient client = Connect(inputs);
  if (action == "status") {
    show(client.Status());
  } else if (action == "load") {
    RequireOption(inputs.mission_path, "mission_path");
    show(client.Load(
        MissionFromJson(ReadJsonFile(inputs.mission_path), inputs.mission_path.string())));
  } else if (action == "preflight") {
    show(client.Preflight());
  } else if (action == "start") {
    AskBeforeStart(client, inputs, JobControl(&program.log, &program.cancel));
    show(client.Start());
  } else if (action == "pause") {
    show(client.Pause());
  } else if (action == "resume") {
    show(client.Resume());
  } else if (action == "abort") {
    if (inputs.how != "rtl" && inputs.how != "land") {
      throw UsageError("--how " + inputs.how + ": must be rtl or land");
    }
    show(client.Abort(inputs.how == "land"));
  } else {
    WatchEvents(client, program.cancel);
  }
  return 0;
}

}  // namespace

int RunFlightClient(const Arguments& arguments, Program& program) {
  CommandLine line("flight_client",
                   "Talks to the flight daemon of a workspace: flight_client status | load | "
                   "preflight | start | pause | resume | abort | watch; and dry_run, which prints "
                   "what a flight would send.");
  line.SetActions({kActions.begin(), kActions.end()});
  ClientInputs inputs;
  line.options().Add("", "workspace_path", &inputs.workspace_path, "folder of the session");
  line.options().Add("", "mission_path", &inputs.mission_path,
                     "load, dry_run: mission to fly (docs/flight_api.md)");
  line.options().Add("", "how", &inputs.how, "abort: rtl (return) or land (here)");
  line.options().Add("", "stack", &inputs.stack, "dry_run: px4 or ardupilot");
  line.options().Add("", "yes", &inputs.yes, "start: do not ask");
  const bool has_action = !arguments.empty() && !arguments[0].starts_with("-");
  const Arguments rest(arguments.begin() + (has_action ? 1 : 0), arguments.end());
  if (!line.Parse(rest, &program.log)) return 0;
  const std::string action = has_action ? arguments[0] : "";
  if (std::find(kActions.begin(), kActions.end(), action) == kActions.end()) {
    throw UsageError(
        "say what to do: status, load, preflight, start, pause, resume, abort, watch or dry_run");
  }
  if (action != "dry_run") RequireOption(inputs.workspace_path, "workspace_path");
  return Perform(action, inputs, program);
}

}  // namespace colmap_ext
