// What became of every view: replayed from the journal, so that nothing is flown twice and no
// picture is lost.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "colmap_ext/scene/capture_journal.h"
#include "colmap_ext/scene/json_file.h"

namespace colmap_ext {

// One picture as the camera, or failing that the daemon, reported it.
struct CaptureReport {
  CaptureRecord record;   // index, time, position (height above mean sea level), attitude
  bool succeeded = true;  // what the camera said
  std::string file_url;   // of the camera; empty: it does not say
  std::optional<double> relative_height_m;
  std::optional<double> ellipsoid_height_m;
  std::optional<double> body_yaw_rad;
  int gps_fix = 0;
};

enum class ViewStatus {
  kPending,
  kAsked,     // the camera was told to take the picture; nobody knows yet whether it did
  kCaptured,  // it did; the file is still in the camera
  kStored,    // the file is in the workspace
  kFailed,    // given up, with a reason
};
const char* Name(ViewStatus status);

struct ViewEntry {
  ViewStatus status = ViewStatus::kPending;
  std::string photo;
  CaptureReport capture;  // from kCaptured on
  int sequence = 0;       // of the last IMAGE_START_CAPTURE, so that a repeated one takes no second
                          // picture
  std::string sha256;     // of the stored low-resolution file
  bool full_stored = false;
  std::string reason;  // of kFailed
};

struct FlightLedger {
  std::map<int, ViewEntry> views;  // by view id
  int next_sequence = 1;           // of captures
  int last_index = -1;             // highest picture index that the camera reported
  // Pictures that the camera reported without being asked for by us, by index: a pilot's.
  std::map<int, CaptureReport> others;
  int flights = 0;          // starts
  bool was_flying = false;  // the journal ends between take-off and disarming
};

// Journal records, one JSON object each; Apply reads them back. `type` is one of
//   start, end                                     a flight begins, the vehicle is disarmed
//   intent  {command, stop}                        before every command to the vehicle
//   ask     {view, photo, sequence, after_index}   before the camera is told to take a picture
//   capture {view (-1: not ours), index, …}        the camera's report
//   stored  {view, resolution, file, sha256}       the file is in the workspace
//   failed  {view, reason}                         a view is given up
//   retry   {view}                                 a view that was given up is pending again
//   new_camera                                     it began to count anew: what was taken and not
//                                                  stored is pending again
//   state   {from, to, reason}
// Throws Error for a record whose fields are missing or wrong; unknown types are skipped.
void ApplyRecord(const JsonNode& record, FlightLedger* ledger);

Json CaptureToJson(int view_id, const CaptureReport& report);
CaptureReport CaptureFromJson(const JsonNode& node);

}  // namespace colmap_ext
