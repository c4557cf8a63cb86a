#include "colmap_ext/sim/picture_store.h"

#include <condition_variable>
#include <cstdio>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

#include "colmap_ext/scene/capture_journal.h"
#include "colmap_ext/scene/true_poses.h"
#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {

namespace fs = std::filesystem;

struct PictureStore::Impl {
  Impl(const SimulatedCamera& the_camera, fs::path the_folder, bool full, Done the_done,
       const JobControl& the_job)
      : camera(the_camera),
        folder(std::move(the_folder)),
        renders_full(full),
        done(std::move(the_done)),
        job(the_job) {}

  fs::path PathOf(const std::string& name, PhotoResolution resolution) const {
    return folder / (resolution == PhotoResolution::kLow ? "low" : "full") / name;
  }

  void Work() {
    std::unique_lock lock(mutex);
    while (true) {
      changed.wait(lock, [&] { return is_stopping || !low_queue.empty() || !full_queue.empty(); });
      if (is_stopping) return;
      const bool is_low = !low_queue.empty();
      std::deque<ShutterEvent>& queue = is_low ? low_queue : full_queue;
      const ShutterEvent event = queue.front();
      queue.pop_front();
      const auto resolution = is_low ? PhotoResolution::kLow : PhotoResolution::kFull;
      lock.unlock();
      const PictureState state = Render(event, resolution);
      lock.lock();
      PictureEntry& entry = entries[entry_of_name.at(NameOf(event.index))];
      (is_low ? entry.low : entry.full) = state;
      lock.unlock();
      done(entry.name, resolution);
      lock.lock();
    }
  }

  // Without the lock.
  PictureState Render(const ShutterEvent& event, PhotoResolution resolution) {
    const std::string name = NameOf(event.index);
    PlannedView view;
    view.id = event.index;
    view.position = event.position;
    view.direction = event.direction;
    try {
      if (resolution == PhotoResolution::kLow) Record(event, name);
      camera.CapturePhoto(view, event.gps, PathOf(name, resolution), resolution);
      return PictureState::kReady;
    } catch (const std::exception& error) {
      job.Warn(error.what());
      return PictureState::kFailed;
    }
  }

  void Record(const ShutterEvent& event, const std::string& name) {
    UpdateTruePoses({{name, CamFromWorld(event.position, event.direction)}},
                    folder / "true_poses.txt");
    CaptureRecord record;
    record.index = event.index;
    record.position = event.gps;
    if (event.sigma_horizontal_m > 0) record.sigma_horizontal_m = event.sigma_horizontal_m;
    if (event.sigma_vertical_m > 0) record.sigma_vertical_m = event.sigma_vertical_m;
    journal += CaptureJournalLine(name, record);
    WriteFileAtomically(folder / "captures.jsonl", journal);
  }

  const SimulatedCamera& camera;
  fs::path folder;
  bool renders_full;
  Done done;
  JobControl job;
  std::string journal;  // of the worker

  std::mutex mutex;
  std::condition_variable changed;
  bool is_stopping = false;
  std::deque<ShutterEvent> low_queue, full_queue;
  std::deque<PictureEntry> entries;  // references stay valid
  std::map<std::string, std::size_t> entry_of_name;
  std::thread worker;
};

std::string PictureStore::NameOf(int index) {
  char name[32];
  std::snprintf(name, sizeof name, "img_%05d.jpg", index);
  return name;
}

PictureStore::PictureStore(const SimulatedCamera& camera, fs::path folder, bool renders_full,
                           Done done, const JobControl& job)
    : impl_(std::make_unique<Impl>(camera, std::move(folder), renders_full, std::move(done), job)) {
  RequireWritableFolder(impl_->folder, "output folder");
  for (const char* sub : {"low", "full"}) {
    fs::create_directories(impl_->folder / sub);
    if (!ListPhotos(impl_->folder / sub).empty()) {
      throw Error((impl_->folder / sub).string() +
                  ": holds pictures of an earlier flight; give an empty --output_path");
    }
  }
  impl_->worker = std::thread([impl = impl_.get()] { impl->Work(); });
}

PictureStore::~PictureStore() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->is_stopping = true;
  }
  impl_->changed.notify_all();
  impl_->worker.join();
}

void PictureStore::Add(const ShutterEvent& event) {
  {
    const std::lock_guard lock(impl_->mutex);
    PictureEntry entry;
    entry.index = event.index;
    entry.time_boot_ms = event.time_boot_ms;
    entry.name = NameOf(event.index);
    if (!impl_->renders_full) entry.full = PictureState::kUnknown;
    impl_->entry_of_name[entry.name] = impl_->entries.size();
    impl_->entries.push_back(entry);
    impl_->low_queue.push_back(event);
    if (impl_->renders_full) impl_->full_queue.push_back(event);
  }
  impl_->changed.notify_all();
}

std::vector<PictureEntry> PictureStore::List() const {
  const std::lock_guard lock(impl_->mutex);
  return {impl_->entries.begin(), impl_->entries.end()};
}

PictureState PictureStore::StateOf(const std::string& name, PhotoResolution resolution) const {
  const std::lock_guard lock(impl_->mutex);
  const auto found = impl_->entry_of_name.find(name);
  if (found == impl_->entry_of_name.end()) return PictureState::kUnknown;
  const PictureEntry& entry = impl_->entries[found->second];
  return resolution == PhotoResolution::kLow ? entry.low : entry.full;
}

fs::path PictureStore::PathOf(const std::string& name, PhotoResolution resolution) const {
  return impl_->PathOf(name, resolution);
}

int PictureStore::NumWaiting() const {
  const std::lock_guard lock(impl_->mutex);
  int waiting = 0;
  for (const PictureEntry& entry : impl_->entries) waiting += entry.low == PictureState::kPending;
  return waiting;
}

}  // namespace colmap_ext
