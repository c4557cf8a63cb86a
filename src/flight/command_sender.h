// Commands with answers: sends, repeats, gives up. Sans-IO.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "colmap_ext/flight/mission_machine.h"
#include "colmap_ext/mavlink/messages.h"

namespace colmap_ext {

using MavCommandMessage = std::variant<MavCommandLong, MavCommandInt>;

// One MAVLink command and how long to insist on it (MAVSDK: 0.5 s, 3 repetitions; more here, so
// that a fifth of all packets may be lost).
struct MavStep {
  MavCommandMessage message;
  double timeout_s = 0.5;
  int tries = 6;
  bool may_fail = false;            // the task goes on whatever the answer
  bool may_be_unsupported = false;  // that answer counts as acceptance
  std::vector<MavStep>
      otherwise;  // 0 or 1: done instead when the vehicle does not know the command
};

struct TaskResult {
  int id = 0;
  CommandKind kind = CommandKind::kPreflight;
  CommandOutcome outcome = CommandOutcome::kAccepted;
  std::string text;
  bool took_fallback = false;  // some step's `otherwise` was done
};

// Tasks run side by side, their steps one after another. Of two steps with the same command number
// the later one waits, for answers carry no other mark. What moves the vehicle, repetitions
// included, waits until its mode is known to be ours later than the wish: a pilot who took it
// meanwhile is not commanded.
class CommandSender {
 public:
  // Replaces an unfinished task of the same kind, or any that changes mode or place when this one
  // does; it then has no result.
  void Start(int id, CommandKind kind, std::vector<MavStep> steps, double now_s);
  void OnAck(const MavCommandAck& ack, double now_s);
  // Forgets every task that moves the vehicle.
  void CancelMotion();
  void Clear() { tasks_.clear(); }
  void Tick(double now_s);
  // The vehicle's mode was heard at `mode_heard_s`, and nobody objects to it.
  void ReleaseMotion(double mode_heard_s, double now_s);

  std::vector<MavCommandMessage> TakeMessages();
  std::vector<TaskResult> TakeResults();

 private:
  struct Task {
    int id = 0;
    CommandKind kind = CommandKind::kPreflight;
    std::vector<MavStep> steps;
    std::size_t step = 0;
    int sent = 0;      // times, of the present step
    double due_s = 0;  // the first sending, or the next
    bool took_fallback = false;
  };

  bool IsBusy(const Task& task) const;
  void SendStep(Task* task, double now_s);
  void Advance(double now_s, const double* mode_heard_s);
  // The present step is over; true when the task is, too.
  bool FinishStep(Task* task, CommandOutcome outcome, const std::string& text, double now_s);

  std::vector<Task> tasks_;
  std::vector<MavCommandMessage> messages_;
  std::vector<TaskResult> results_;
};

const char* Name(MavResult result);

}  // namespace colmap_ext
