// The daemon's journal: append only, each line on disk before what it announces is done.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "colmap_ext/flight/flight_ledger.h"

namespace colmap_ext {

class FlightJournal {
 public:
  // Opens or creates the file and cuts off a last line that a crash left unfinished. Throws Error
  // naming the file when it cannot be written, or when a whole line is no record.
  explicit FlightJournal(const std::filesystem::path& path);
  ~FlightJournal();
  FlightJournal(const FlightJournal&) = delete;
  FlightJournal& operator=(const FlightJournal&) = delete;

  // What the file said when it was opened.
  const FlightLedger& ledger() const { return ledger_; }

  // Writes the lines and waits until they are on disk. Throws Error when they cannot be.
  void Append(const std::vector<Json>& records);

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  FlightLedger ledger_;
};

// The ledger of a journal's text; a last line without line end is ignored. `whole_bytes` (may be
// null): how many bytes are whole lines. Throws Error naming `name` and the line.
FlightLedger ReplayJournal(const std::string& text, const std::string& name,
                           std::size_t* whole_bytes = nullptr);

}  // namespace colmap_ext
