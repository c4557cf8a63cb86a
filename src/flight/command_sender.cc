#include "flight/command_sender.h"

#include <algorithm>
#include <array>
#include <utility>

namespace colmap_ext {
namespace {

constexpr double kInProgressS = 3;  // after the vehicle said that it works on it

MavCmd CommandOf(const MavStep& step) {
  return std::visit([](const auto& message) { return message.command; }, step.message);
}

bool IsUnknownTo(MavResult result) {
  return result == MavResult::kUnsupported || result == MavResult::kCommandLongOnly ||
         result == MavResult::kCommandIntOnly || result == MavResult::kDenied;
}

// What tells the vehicle where to be or in what mode: only the last one counts. A repetition of an
// older one would undo it.
bool IsWay(CommandKind kind) {
  return IsMotion(kind) && kind != CommandKind::kTurn && kind != CommandKind::kAim;
}

}  // namespace

const char* Name(MavResult result) {
  constexpr std::array kNames = {"accepted",
                                 "temporarily rejected",
                                 "denied",
                                 "unsupported",
                                 "failed",
                                 "in progress",
                                 "cancelled",
                                 "only as COMMAND_LONG",
                                 "only as COMMAND_INT",
                                 "unsupported frame"};
  const auto index = static_cast<std::size_t>(result);
  return index < kNames.size() ? kNames[index] : "an unknown answer";
}

void CommandSender::Start(int id, CommandKind kind, std::vector<MavStep> steps, double now_s) {
  std::erase_if(tasks_, [kind](const Task& task) {
    return task.kind == kind || (IsWay(kind) && IsWay(task.kind));
  });
  if (steps.empty()) {
    results_.push_back({id, kind, CommandOutcome::kAccepted, "", false});
    return;
  }
  tasks_.push_back({id, kind, std::move(steps), 0, 0, now_s, false});
  Tick(now_s);
}

bool CommandSender::IsBusy(const Task& task) const {
  return std::any_of(tasks_.begin(), tasks_.end(), [&](const Task& other) {
    return &other != &task && other.sent > 0 &&
           CommandOf(other.steps[other.step]) == CommandOf(task.steps[task.step]);
  });
}

void CommandSender::SendStep(Task* task, double now_s) {
  MavStep& step = task->steps[task->step];
  if (auto* message = std::get_if<MavCommandLong>(&step.message)) {
    message->confirmation = static_cast<std::uint8_t>(task->sent);
  }
  messages_.push_back(step.message);
  ++task->sent;
  task->due_s = now_s + step.timeout_s;
}

bool CommandSender::FinishStep(Task* task, CommandOutcome outcome, const std::string& text,
                               double now_s) {
  MavStep& step = task->steps[task->step];
  const bool is_good = outcome == CommandOutcome::kAccepted || step.may_fail;
  if (!is_good) {
    results_.push_back({task->id, task->kind, outcome, text, task->took_fallback});
    return true;
  }
  ++task->step;
  task->sent = 0;
  task->due_s = now_s;
  if (task->step < task->steps.size()) return false;
  results_.push_back({task->id, task->kind, CommandOutcome::kAccepted, "", task->took_fallback});
  return true;
}

void CommandSender::OnAck(const MavCommandAck& ack, double now_s) {
  for (auto task = tasks_.begin(); task != tasks_.end(); ++task) {
    MavStep& step = task->steps[task->step];
    if (task->sent == 0 || CommandOf(step) != ack.command) continue;
    if (ack.result == MavResult::kInProgress) {
      task->due_s = now_s + kInProgressS;
      return;
    }
    if (IsUnknownTo(ack.result) && !step.otherwise.empty()) {
      task->steps[task->step] = MavStep(step.otherwise.front());
      task->sent = 0;
      task->due_s = now_s;
      task->took_fallback = true;
    } else {
      const bool is_accepted = ack.result == MavResult::kAccepted ||
                               (step.may_be_unsupported && ack.result == MavResult::kUnsupported);
      if (FinishStep(&*task, is_accepted ? CommandOutcome::kAccepted : CommandOutcome::kRejected,
                     Name(ack.result), now_s)) {
        tasks_.erase(task);
      }
    }
    Tick(now_s);
    return;
  }
}

void CommandSender::CancelMotion() {
  std::erase_if(tasks_, [](const Task& task) { return IsMotion(task.kind); });
}

void CommandSender::Tick(double now_s) { Advance(now_s, nullptr); }

void CommandSender::ReleaseMotion(double mode_heard_s, double now_s) {
  Advance(now_s, &mode_heard_s);
}

// `mode_heard_s`: null when what moves the vehicle has to wait.
void CommandSender::Advance(double now_s, const double* mode_heard_s) {
  const auto may_send = [&](const Task& task) {
    if (!IsMotion(task.kind)) return true;
    return mode_heard_s != nullptr && *mode_heard_s >= task.due_s;
  };
  for (auto task = tasks_.begin(); task != tasks_.end();) {
    if (task->sent == 0) {
      if (!IsBusy(*task) && may_send(*task)) SendStep(&*task, now_s);
    } else if (now_s >= task->due_s) {
      if (task->sent < task->steps[task->step].tries) {
        if (may_send(*task)) SendStep(&*task, now_s);
      } else if (FinishStep(&*task, CommandOutcome::kNoAnswer, "no answer", now_s)) {
        task = tasks_.erase(task);
        continue;
      } else {
        continue;  // the next step, at once
      }
    }
    ++task;
  }
}

std::vector<MavCommandMessage> CommandSender::TakeMessages() {
  return std::exchange(messages_, {});
}

std::vector<TaskResult> CommandSender::TakeResults() { return std::exchange(results_, {}); }

}  // namespace colmap_ext
