// Damage for tests of readers: whatever a file holds, a reader answers or throws Error.
#pragma once

#include <filesystem>
#include <functional>
#include <random>
#include <string>

#include "colmap_ext/util/error.h"
#include "colmap_ext/util/files.h"

namespace colmap_ext {

// Calls `read` on `text` with bytes replaced, removed, doubled, and cut short, `times` times; an
// exception that is no Error comes through. Returns how many of them were refused with a message of
// one line that names the file.
inline int CountRefused(const std::string& text, const std::filesystem::path& path, int times,
                        const std::function<void(const std::filesystem::path&)>& read) {
  std::mt19937 random(7);
  const auto below = [&random](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  int num_refused = 0;
  for (int i = 0; i < times; ++i) {
    std::string damaged = text;
    for (std::size_t k = 0; k <= below(4); ++k) {
      const std::size_t at = below(damaged.size());
      switch (below(4)) {
        case 0:
          damaged[at] = static_cast<char>(below(256));
          break;
        case 1:
          damaged.erase(at, 1 + below(8));
          break;
        case 2:
          damaged.insert(at, damaged.substr(below(damaged.size()), below(40)));
          break;
        default:
          if (below(5) == 0) damaged.resize(at);
      }
      if (damaged.empty()) damaged = "x";
    }
    WriteFileAtomically(path, damaged);
    try {
      read(path);
    } catch (const Error& error) {
      const std::string message = error.what();
      const bool is_good = message.find(path.filename().string()) != std::string::npos &&
                           message.find('\n') == std::string::npos;
      num_refused += is_good ? 1 : 0;
      if (!is_good) throw std::runtime_error("bad message: " + message);
    }
  }
  return num_refused;
}

}  // namespace colmap_ext
