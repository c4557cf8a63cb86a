#include "ask_yes.h"

#include <poll.h>
#include <unistd.h>

#include <iostream>

namespace colmap_ext {

bool AskYes(const std::string& text, const JobControl& job) {
  constexpr int kPollMs = 200;
  std::cout << text << "The vehicle will arm and take off. Type yes to start: " << std::flush;
  std::string answer;
  while (true) {
    job.ThrowIfCancelled();
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (poll(&input, 1, kPollMs) <= 0) continue;
    char letter = 0;
    if (read(STDIN_FILENO, &letter, 1) != 1 || letter == '\n') return answer == "yes";
    answer += letter;
  }
}

}  // namespace colmap_ext
